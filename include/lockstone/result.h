// Errors that come from outside: files, packets, definitions, capacities. A programmer's error asserts instead.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace lockstone {

/// One sentence a user can act on: what was wrong, where, and what would have been right.
struct Error {
    std::string message;
};

/// A value or an Error. `if (!result) report(result.error().message);`
template <class T> class [[nodiscard]] Result {
    std::variant<T, Error> content;

  public:
    Result(T value) : content(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : content(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return content.index() == 0; }
    bool ok() const { return content.index() == 0; }
    T& value() & { return assert(ok()), *std::get_if<0>(&content); }
    const T& value() const& { return assert(ok()), *std::get_if<0>(&content); }
    T&& value() && { return assert(ok()), std::move(*std::get_if<0>(&content)); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const { return assert(!ok()), *std::get_if<1>(&content); }
};

template <> class [[nodiscard]] Result<void> {
    std::variant<std::monostate, Error> content;

  public:
    Result() = default;
    Result(Error error) : content(std::move(error)) {}

    explicit operator bool() const { return content.index() == 0; }
    bool ok() const { return content.index() == 0; }
    /// Says that it went well (asserted): `world.add_force(...).value();` where an error would be the game's own.
    void value() const { assert(ok()); }
    const Error& error() const { return assert(!ok()), *std::get_if<1>(&content); }
};

using Status = Result<void>;

} // namespace lockstone
