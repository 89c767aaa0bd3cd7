// The hashes of each world after each tick, with which self_test() compares. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
    0xca922891149b11e5u, 0x7a9a886113e8dd22u, 0x842b6037149accfbu, 0xa86e870f5666b62au, 0x708388631277f3cfu, 0x73261bd1e0e920d1u,
    0xccee2f48e31f4f32u, 0xa2e49ee0df275c02u, 0xf0f29d584190805cu, 0x1fee19dacc8ddd61u, 0x48f0bd9cd9634ac9u, 0x7ea5a18c0bac6967u,
    0x5beb5b0ba0c506adu, 0xe7d192df329cebbeu, 0xff9da7e2973a727eu, 0x956d9bd8cc90a2a7u, 0xaf92f6cc9a2784beu, 0xe82764eb822a9b45u,
    0x9d76b2773ee83600u, 0xc71bde28de6ddfb6u, 0x7951dd34a6c7ae85u, 0xfb5c14609d37baffu, 0xc8a8575d952ebec6u, 0xe1a5967426b0705du,
    0x8ecd9950100c79f7u, 0x2a5678666e256e2cu, 0xf78b0efa1d455e04u, 0x2dd9e9863884ac3cu, 0x2e0595d48686ab37u, 0x14170fc81e1a1fe9u,
    0x79bec4249f2dad14u, 0x6b456be1c47ad531u, 0x1a2f4b726f86d805u, 0x8928413c805cbba8u, 0x3d166bd701c23ec1u, 0x1c9a7d98840c8f6cu,
    0x88d454f79d151377u, 0xe1733d2c125c398bu, 0x137509b23696cf80u, 0x2047cde279470c85u, 0x66f2ed04e7de72dau, 0x940c0c967ba29bdfu,
    0xa2a6a311a18ce101u, 0xe34b34df0a566e76u, 0x0a41b27eb0efa6b0u, 0xfb030a7aa22a040cu, 0xced3954e0116c8c1u, 0x7df8e3162f5bc9bfu,
    0x6f4dae7b5df811c3u, 0xd0a8ebfaab73a6f4u, 0xfb9caa40c5a598ceu, 0x9125f1657612a6cbu, 0xb90008ab02c3b653u, 0x542bc98e042e005eu,
    0x7a8fe507eddf7463u, 0x14fdc9e072d4d256u, 0x035432cba4e357aau, 0x8ab1e6e8ef864787u, 0x8ebe1718e874594cu, 0x4a7bc5978e6dd33eu,
};
// clang-format on

} // namespace lockstone::proofs
