// Extensions of compilers beyond C++20, and vector instructions of processors. Each has a portable
// replacement with equal bits.
//
// g++ and clang have all extensions, MSVC only the x86 intrinsics. -DLOCKSTONE_PLAIN_CPLUSPLUS=1 selects the
// replacements. Each macro is 0 or 1.
#pragma once

/// 1: portable C++20 only. Default: 0.
#if !defined(LOCKSTONE_PLAIN_CPLUSPLUS)
#define LOCKSTONE_PLAIN_CPLUSPLUS 0
#endif

/// 1: builtin functions for overflow, constants and prefetch; inline assembly.
#if (defined(__GNUC__) || defined(__clang__)) && !LOCKSTONE_PLAIN_CPLUSPLUS
#define LOCKSTONE_GNU 1
#else
#define LOCKSTONE_GNU 0
#endif

/// 1: a 128-bit integer. Not for clang with the MSVC runtime library, which cannot divide it.
#if LOCKSTONE_GNU && defined(__SIZEOF_INT128__) && !defined(_MSC_VER)
#define LOCKSTONE_HAS_INT128 1
#else
#define LOCKSTONE_HAS_INT128 0
#endif

/// 1: vector instructions of x86 (immintrin.h), of little-endian 64-bit ARM, of WebAssembly.
#if (defined(__x86_64__) || defined(__i386__) || defined(_M_X64)) && !LOCKSTONE_PLAIN_CPLUSPLUS
#define LOCKSTONE_HAS_X86 1
#else
#define LOCKSTONE_HAS_X86 0
#endif
#if defined(__aarch64__) && !defined(__AARCH64EB__) && !LOCKSTONE_PLAIN_CPLUSPLUS
#define LOCKSTONE_HAS_NEON 1
#else
#define LOCKSTONE_HAS_NEON 0
#endif
#if defined(__wasm_simd128__) && !LOCKSTONE_PLAIN_CPLUSPLUS
#define LOCKSTONE_HAS_WASM128 1
#else
#define LOCKSTONE_HAS_WASM128 0
#endif
