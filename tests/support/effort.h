// The number of tries of a test. Sanitizers take ten to twenty times as long, so their builds run a sample.
#pragma once

#include <cstdlib>

#ifndef __has_feature
#define __has_feature(name) 0 // clang's
#endif

namespace lockstone::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || __has_feature(address_sanitizer) ||     \
    __has_feature(thread_sanitizer)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

/// LOCKSTONE_LONG=1 in the environment: all tries, in all builds.
inline bool is_long_run() { return std::getenv("LOCKSTONE_LONG") != nullptr; }

/// For doctest::skip: a search over numbers, or a long motion, whose code shorter tests run too.
inline bool is_too_long_here() { return is_sanitized && !is_long_run(); }

/// For doctest::skip with LOCKSTONE_SAMPLE=1 in the environment, which tests/run sets without an option: also skips a
/// sanitized test that takes over 4 seconds and whose code other tests run.
inline bool is_small_sample() { return is_too_long_here() && std::getenv("LOCKSTONE_SAMPLE") != nullptr; }

/// Number of tries: all of them, or an eighth under a sanitizer.
inline int tries(int whole) { return is_too_long_here() ? (whole + 7) / 8 : whole; }

} // namespace lockstone::test
