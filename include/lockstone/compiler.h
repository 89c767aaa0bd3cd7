// What the library asks of a compiler beyond C++20, and of a processor beyond scalars: each has a form without, with the same bits.
//
// g++ and clang have all of it, MSVC's cl the intrinsics of x86 alone. -DLOCKSTONE_PLAIN_CPLUSPLUS=1 takes the form without everywhere. Macros are
// 0 or 1, and never undefined.
#pragma once

#if !defined(LOCKSTONE_PLAIN_CPLUSPLUS)
#define LOCKSTONE_PLAIN_CPLUSPLUS 0
#endif

/// Builtin functions of overflow, constants and prefetching; inline assembly.
#if (defined(__GNUC__) || defined(__clang__)) && !LOCKSTONE_PLAIN_CPLUSPLUS
#define LOCKSTONE_GNU 1
#else
#define LOCKSTONE_GNU 0
#endif

/// A 128-bit integer. Clang has the type where it follows MSVC, but the runtime library there cannot divide it.
#if LOCKSTONE_GNU && defined(__SIZEOF_INT128__) && !defined(_MSC_VER)
#define LOCKSTONE_HAS_INT128 1
#else
#define LOCKSTONE_HAS_INT128 0
#endif

/// Headers with the vector instructions of x86 (immintrin.h), of 64-bit ARM with the low byte first, and of WebAssembly.
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
