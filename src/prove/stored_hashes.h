// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0x31aebb93258b21dfu, 0x839f022c7f637ee5u, 0x2a458b6fdc758947u, 0x819848d2eacb0118u, 0x5b7f41c80507f788u, 0xcab6e4dcf658d24bu,
    0x6a29f5222e701c7eu, 0x660eefe533479cacu, 0xd96fce4bb384b602u, 0xb6201996a39193d9u, 0x8cd9c347eda0f3f5u, 0x9a2f63b352d267c5u,
    0x2cf92052328d8ed7u, 0x9a424ef920d6e8f7u, 0x9137be34e628524eu, 0x2555ac52efb8be88u, 0xe9ffc8445c9f9494u, 0xc83f73333cc09cccu,
    0x5a0a1e68530b682bu, 0x033b909b350431edu, 0x8ae915e3c55cd757u, 0xeba3f760518eda4bu, 0xe97f3d7e2eaef92cu, 0x378bf487a9190b58u,
    0xf5ebcb80f8403efeu, 0x0bd1895f955ef741u, 0xce4a411b906ebea3u, 0x0e92bb1926fe24bfu, 0xf8580558f8a92af7u, 0xa46ef15ff5f3894cu,
    0xafb1b5e46fb273c9u, 0xf8eb51686f6e3a48u, 0xfe17c2f2178e1a92u, 0xc55fb6f9fd92e8dcu, 0x14fc1bd1b7df099cu, 0x087179e6e3ba451eu,
    0x1eab10340da64b80u, 0x1ed99f66ebacd5cfu, 0x4c2089daa282ae90u, 0x481e6f448dd6b524u, 0x8f07bf72541a45d1u, 0x984d2606b99fdf3bu,
    0x1543295a729d2055u, 0xa61efe263bf7d11fu, 0x8d5869d20b989993u, 0x9b3c034a1d6b5fe7u, 0x5dc2760c603fb1dbu, 0x47dd556f8eadfb3au,
    0x402be489b004492cu, 0x83aae9ad7c7886d1u, 0xfcf5c41261660dd8u, 0xb2f6c074baae5306u, 0xda2b90e7154854a1u, 0x9714a08258ab0f4fu,
    0x9ba6863828318e0du, 0xd94a027bf38976a4u, 0xbb0af25bc78dc6c6u, 0x1bba8a465a886ba1u, 0x1b00e5127a5188f8u, 0xeee55351cddefe71u,
    0xd2887fa495f2d0e0u, 0x2aec5b21899963c9u, 0x598ef426e789187fu, 0x0c9aee1eb8036332u, 0xb15b3143afddba93u, 0x734d87efe67785cau,
    0xdc9ffb1465573382u, 0x5f7c0ab8ef676b26u, 0x5cffb57c4fdd68edu, 0xdd358bc163741194u, 0x38ffd234d691a98du, 0x8608e8237791e92bu,
    0x24b44fb05b2f88afu, 0xfd25e1828c64d226u, 0x2abe9bd129383de8u, 0x87a587080ad1d5ceu, 0x5417530ac6f5973cu, 0x9cb69b82567430b1u,
    0x87309c05b1898082u, 0x3533d1848c133ffcu,
};
// clang-format on

} // namespace lockstone::proofs
