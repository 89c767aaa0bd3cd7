// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0xca922891149b11e5u, 0x7a9a886113e8dd22u, 0x842b6037149accfbu, 0x598cbd3915f3964fu, 0xb485d98077456913u, 0xf184ca30633c8c4au,
    0x82d021100c6c70b6u, 0x60d05f276edbf9c5u, 0xc58767e19a0c65d8u, 0x3d6231def023ed3du, 0x573ef21e4a97c83eu, 0xe593237f521ac41eu,
    0x5beb5b0ba0c506adu, 0x2aae762945e32d50u, 0x01e1d37932635f9au, 0xa4c777f731cbc5a1u, 0x466425ce0d232594u, 0xb275c9a740bc67c6u,
    0x6d3ea7b5ecf49626u, 0x70b223779d6991bbu, 0x265917eae8cb7879u, 0x2f065a00e465c2aeu, 0xfc757864b83e4ec7u, 0xdece9b6139189042u,
    0x8ecd9950100c79f7u, 0x4c3008e2571d6cecu, 0x701cb155a5633137u, 0x2dd9e9863884ac3cu, 0x2e0595d48686ab37u, 0x14170fc81e1a1fe9u,
    0x4a8ed6f43ef7ba89u, 0x330e3b50d9d1f56bu, 0x86d2eeecf7067bcfu, 0xc56a339509a0115bu, 0xe0684fa193046ff7u, 0x920159d39f0f84a5u,
    0x88d454f79d151377u, 0x03985ec647a5c1d4u, 0x2c259bc7fdca45a5u, 0x215b83c781903267u, 0xe07ac54d63976a35u, 0x2af3cf54640eeae7u,
    0xc029754c8ed470acu, 0x21c381b1f1c8538cu, 0xa157d0c6d4083633u, 0x07775406c7fcb424u, 0xf9bb8f39304fe294u, 0x3e501e8907708f76u,
    0x6f4dae7b5df811c3u, 0xd0a8ebfaab73a6f4u, 0xfb9caa40c5a598ceu, 0x3ce89de83e186537u, 0x12062c90667b7193u, 0xc51ca9dac79d4634u,
    0xf2e5d84d170ddb93u, 0x112228a85d876b43u, 0x1db8dfec19d36c16u, 0x25e902e1375cfc4cu, 0x4c7f216be3dcfce4u, 0x5b2f00bdd88ad162u,
};
// clang-format on

} // namespace lockstone::proofs
