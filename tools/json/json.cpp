#include "json/json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace lockstone::json {

/// Converts values to those of the JSON library. No other code uses the library.
struct Writer {
    using Other = nlohmann::ordered_json;

    static Other other(const Value& value) {
        using Kind = Value::Kind;
        switch (value.kind) {
        case Kind::boolean:
            return value.whole != 0;
        case Kind::whole:
            return value.whole;
        case Kind::natural:
            return static_cast<std::uint64_t>(value.whole);
        case Kind::real:
            return value.real;
        case Kind::text:
            return value.text;
        case Kind::array:
            return array(value);
        case Kind::object:
            return object(value);
        case Kind::null:
            break;
        }
        return nullptr;
    }

    static Other array(const Value& value) {
        Other all = Other::array();
        for (const Value& item : value.list) all.push_back(other(item));
        return all;
    }

    static Other object(const Value& value) {
        Other all = Other::object();
        for (const Member& member : value.named) all.emplace(member.key, other(member.value));
        return all;
    }
};

namespace {

template <class Members> auto find(Members& members, std::string_view key) {
    return std::ranges::find(members, key, &Member::key);
}

void expect(bool good, const char* kind) {
    if (!good) throw std::logic_error(std::string("JSON: this is no ") + kind);
}

} // namespace

Value::Value() = default;
Value::Value(std::nullptr_t) {}
Value::Value(Kind k) : kind(k) {}
Value::Value(double x) : kind(Kind::real), real(x) {}
Value::Value(const char* t) : kind(Kind::text), text(t) {}
Value::Value(std::string_view t) : kind(Kind::text), text(t) {}
Value::Value(std::string t) : kind(Kind::text), text(std::move(t)) {}

Value::Value(std::initializer_list<Value> items) : kind(Kind::array) {
    const auto is_member = [](const Value& item) {
        return item.kind == Kind::array && item.list.size() == 2 && item.list[0].kind == Kind::text;
    };
    if (!std::ranges::all_of(items, is_member)) {
        list = items;
        return;
    }
    kind = Kind::object;
    for (const Value& item : items)
        if (find(named, item.list[0].text) == named.end()) named.push_back({item.list[0].text, item.list[1]});
}

Value::Value(const Value& other) = default;
Value::Value(Value&& other) noexcept = default;
Value& Value::operator=(const Value& other) = default;
Value& Value::operator=(Value&& other) noexcept = default;
Value::~Value() = default;

Value Value::array() { return Value(Kind::array); }
Value Value::object() { return Value(Kind::object); }

Value& Value::operator[](std::string_view key) {
    if (is_null()) kind = Kind::object;
    expect(is_object(), "object");
    if (const auto found = find(named, key); found != named.end()) return found->value;
    return named.emplace_back(Member{std::string(key), {}}).value;
}

const Value& Value::at(std::string_view key) const {
    const auto found = find(named, key);
    if (found == named.end()) throw std::out_of_range("JSON: there is no member " + std::string(key));
    return found->value;
}

bool Value::contains(std::string_view key) const { return find(named, key) != named.end(); }

const std::vector<Member>& Value::members() const {
    expect(is_object(), "object");
    return named;
}

void Value::update(const Value& object) {
    for (const Member& member : object.members()) (*this)[member.key] = member.value;
}

void Value::push_back(Value item) {
    if (is_null()) kind = Kind::array;
    expect(kind == Kind::array, "array");
    list.push_back(std::move(item));
}

Value& Value::back() {
    if (list.empty()) throw std::out_of_range("JSON: the array is empty");
    return list.back();
}

const Value& Value::at(std::size_t index) const { return list.at(index); }
std::vector<Value>::const_iterator Value::begin() const { return list.begin(); }
std::vector<Value>::const_iterator Value::end() const { return list.end(); }

bool Value::as_bool() const {
    expect(kind == Kind::boolean, "bool");
    return whole != 0;
}

int Value::as_int() const {
    expect(kind == Kind::whole || kind == Kind::natural, "whole number");
    if (!std::in_range<int>(whole)) throw std::out_of_range("JSON: the number does not fit into an int");
    return static_cast<int>(whole);
}

double Value::as_double() const {
    if (kind == Kind::real) return real;
    expect(kind == Kind::whole || kind == Kind::natural, "number");
    return kind == Kind::whole ? static_cast<double>(whole)
                               : static_cast<double>(static_cast<std::uint64_t>(whole));
}

const std::string& Value::as_text() const {
    expect(is_text(), "text");
    return text;
}

std::string Value::dump(int indent) const {
    // Writes ASCII only, so that no control character in a name reaches a terminal.
    return Writer::other(*this).dump(indent, ' ', true, Writer::Other::error_handler_t::replace);
}

} // namespace lockstone::json
