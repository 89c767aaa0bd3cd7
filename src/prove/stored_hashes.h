// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0xca922891149b11e5u, 0x7a9a886113e8dd22u, 0x2383b324c3c99ebfu, 0x058c1cc8a500bf9du, 0x71c88f46527169cbu, 0x073e502edb1ef19fu,
    0xf0fb433275c2c288u, 0x18ef8eac233a3087u, 0x2655538b21c01c84u, 0x3d8ab71e63449d75u, 0x343940e651c76b45u, 0xb7e9bd4430a13c18u,
    0x429061066bdf0d1eu, 0x52faf69fc76b7c1bu, 0xa6b4cec72939d26du, 0x6d161fb736d5d36du, 0x63719a8c5fc9c0d5u, 0x4653d607b59b1110u,
    0xf9380a963d851b6bu, 0xc54a65462fc7fdeau, 0xc34feb69c677d87cu, 0xfb0c0f852f58ebcfu, 0xf27644e78bb7404eu, 0x5b9fb33c8e7d6b29u,
    0x777e594384199c14u, 0xf723572c64196e13u, 0x20c17df6dc09b4d4u, 0xbd53ee73e1550bd3u, 0x9ce29b77d8eeb746u, 0xe225e8460cc74102u,
    0x18f142b520296a60u, 0xc9f16ef5cc608d89u, 0xabf720815f632946u, 0x9113652aa7a2e9d8u, 0xed06175dcd8df423u, 0x81fe386a81db5324u,
    0xe0636d7ffc0c024fu, 0xa87c6853c758e677u, 0x76c0a044492a3fb5u, 0x97277cc83f147242u, 0x0ba669ad7ba8f1beu, 0xb56cf4f4b910318bu,
    0x866cef2bc3b1eb3fu, 0xc48d1e35ab9efbacu, 0x9c7473edff215eceu, 0x2f76c95b0f17b596u, 0x3ad0db4211cf5734u, 0xb87d4f7bb56265e1u,
    0x8f2a79148e504b5fu, 0x22a4c6bfc4cea448u, 0x365b46fdaef30b56u, 0xf3a7a47d6df9186bu, 0xf6bd7120b9d2faceu, 0x437057becabb42fbu,
    0xf24ff4b5e9bde5ddu, 0xa1e1621d0433fd51u, 0x73ad89f4cbb85a9cu, 0xeff51376353496afu, 0xf80757ce9b680ba8u, 0x9b33ca691b4a1612u,
};
// clang-format on

} // namespace lockstone::proofs
