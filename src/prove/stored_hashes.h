// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0x9a531cdae6e76c49u, 0x7bf691dae6ba091fu, 0x7916f50ef28a2ce3u, 0x6ba773254634473du, 0x32486c3d31136f92u, 0xd672a2c03bc936b0u,
    0xbba4510f130c5584u, 0x27e8d9c60798084fu, 0x64b08e4117c1a4b8u, 0xcba4fac7c5a929a8u, 0x1ed61d810078f838u, 0x3689599d5cc26339u,
    0x23e0e7f003049080u, 0x9eb710b22a958331u, 0xf682b684cc1869d1u, 0xeec146c7bc4d7653u, 0x8944b04500159964u, 0xec266d2b3455dfb6u,
    0x7b10085daf319e73u, 0xf859170f9d661815u, 0x8ccbbf0977802f07u, 0x0bec29cd7f020641u, 0x4adc131de184f6dau, 0xcbf8f2107d1bfeefu,
    0x9d1d01f015d47151u, 0x9b37d88e246b0dd3u, 0xd442b0ba0b7e6a80u, 0x20b0618ccc357abau, 0x78e992e3cdf199e5u, 0xd4dbf1d19fcd9470u,
    0xfe7e6e788694ecafu, 0x3bf20f83a8475aa5u, 0xcfb42c5754cbc81du, 0xe59749c70f6afb09u, 0xb52923c48686b968u, 0x6fade30cd6e6de10u,
    0x0d04750f5f33430au, 0x7bf7200e915bbf7du, 0xe67c26f33408cf49u, 0xe5bcbbe7790a9db2u, 0x6996689d8367e6d1u, 0x4142be393c92bd3cu,
    0x223d101005aa7e19u, 0xd411b06a4bf10401u, 0xf40f1502a8880690u, 0xba844cc7dfd69bf6u, 0xbf5a839c243621d0u, 0xc32522429df649acu,
    0x27d06ff3718f3041u, 0x83cf4395ccd15ee3u, 0xd4c2bde69a6c02fdu, 0x6773ecbb12faca89u, 0x25951f3581c46de3u, 0xde73b809778c7167u,
    0x94e85a715c0d1851u, 0x50b11ab7a3f64207u, 0x1ed64a1e464d255bu, 0x0d8bdb2a3f83fdfcu, 0x634ea4bc13f5cf32u, 0x58bacba278813a06u,
};
// clang-format on

} // namespace lockstone::proofs
