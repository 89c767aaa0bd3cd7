// The expected reactions to wrong arguments: an error that names the argument, or the end of the program with a
// sentence.
#pragma once

#include "lockstone/result.h"
#include "support/stops.h"

#include <doctest/doctest.h>

#include <functional>

namespace lockstone::test {

inline void refused(const char* what, const Status& status, const char* word) {
    CAPTURE(what);
    REQUIRE_FALSE(status.ok());
    CHECK_MESSAGE(status.error().message.find(word) != std::string::npos, status.error().message);
}
template <class T> Status status_of(const Result<T>& result) {
    return result ? Status{} : Status{result.error()};
}
inline void stops(const char* what, const std::function<void()>& call) {
    CAPTURE(what);
    const std::string words = last_words(call);
    CHECK_MESSAGE(words.starts_with("lockstone: broken rule: "), words);
}

} // namespace lockstone::test
