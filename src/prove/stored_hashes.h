// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0x31aebb93258b21dfu, 0x4974a4ac40eedbc5u, 0x5d67249d7537c388u, 0x0e9f17b0d1569dabu, 0x5b7f41c80507f788u, 0xcab6e4dcf658d24bu,
    0x6a29f5222e701c7eu, 0x660eefe533479cacu, 0xa381fc0af331d21fu, 0x9bf3996bf8be2f26u, 0x703d573b67def2adu, 0xf85de78880891007u,
    0x2cf92052328d8ed7u, 0x9a424ef920d6e8f7u, 0x9137be34e628524eu, 0x2555ac52efb8be88u, 0xe9ffc8445c9f9494u, 0xc83f73333cc09cccu,
    0x5a0a1e68530b682bu, 0x033b909b350431edu, 0x8ae915e3c55cd757u, 0xeba3f760518eda4bu, 0xe97f3d7e2eaef92cu, 0x378bf487a9190b58u,
    0xf5ebcb80f8403efeu, 0x0bd1895f955ef741u, 0xce4a411b906ebea3u, 0x0e92bb1926fe24bfu, 0xf8580558f8a92af7u, 0xa46ef15ff5f3894cu,
    0xafb1b5e46fb273c9u, 0xf8eb51686f6e3a48u, 0xfff01ff2646f2d2fu, 0xc55fb6f9fd92e8dcu, 0x14fc1bd1b7df099cu, 0x087179e6e3ba451eu,
    0xe52c45457c828c74u, 0x411df3d42b39d8c1u, 0x05bcff63478228cfu, 0xf26cefed39b99045u, 0xb0f4fa00097eafe5u, 0x139a45289d68916fu,
    0x96331e182d6b2107u, 0x16c08d3f14162080u, 0x66fca62a92f5b2d6u, 0xaba4649ee3ce7d59u, 0x593de45e26d32b8cu, 0xb8fb8cfb4644f32au,
    0x402be489b004492cu, 0x83aae9ad7c7886d1u, 0xfcf5c41261660dd8u, 0xb2f6c074baae5306u, 0xda2b90e7154854a1u, 0x9714a08258ab0f4fu,
    0x3ea2c39f720f9168u, 0x85670fe1b730739eu, 0xe9b3a404eba979fdu, 0x545bec1bf6591276u, 0xc5d0d68d8da5ee26u, 0xa30545902c24254cu,
    0xd2887fa495f2d0e0u, 0xc643af124fd001e1u, 0x598ef426e789187fu, 0x0c9aee1eb8036332u, 0xb15b3143afddba93u, 0x734d87efe67785cau,
    0xdc9ffb1465573382u, 0x5f7c0ab8ef676b26u, 0x5cffb57c4fdd68edu, 0xdd358bc163741194u, 0x38ffd234d691a98du, 0x8608e8237791e92bu,
    0x071a13de691e0b83u, 0x43ff0f08862bdb9fu, 0x17c1ea53fb914d39u, 0x9e2a358c42c3e9b6u, 0x5417530ac6f5973cu, 0x9cb69b82567430b1u,
    0x87309c05b1898082u, 0x3533d1848c133ffcu,
};
// clang-format on

} // namespace lockstone::proofs
