// JSON values for machine-readable output of the command line: `--json`, reports, traces.
//
//     Value row{{"scene", "S1"}, {"ticks", 600}, {"mean_ms", {1.5, 2.5}}};
//     row["good"] = true;
//     row.dump(2);
//
// Only json.cpp includes the JSON library: its header takes longer to compile than a command.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::json {

struct Member;

/// Null, a bool, a number, a text, an array or an object. The members of an object keep the order in which they were
/// added. Access to a missing member or item, or to a value of another kind, throws std::out_of_range or
/// std::logic_error with the name.
class Value {
  public:
    Value();
    Value(std::nullptr_t);
    template <std::same_as<bool> T> Value(T x) : kind(Kind::boolean), whole(x) {}
    template <std::signed_integral T> Value(T x) : kind(Kind::whole), whole(x) {}
    template <std::unsigned_integral T>
    requires(!std::same_as<T, bool>) Value(T x)
        : kind(Kind::natural), whole(static_cast<std::int64_t>(std::uint64_t{x})) {}
    Value(double x); ///< infinite and not-a-number are written as null
    Value(const char* text);
    Value(std::string_view text);
    Value(std::string text);
    template <class T> Value(const std::vector<T>& items) : Value(array()) {
        for (const T& item : items) push_back(item);
    }
    /// If every item is a pair that begins with a text, the list becomes an object, otherwise an array.
    Value(std::initializer_list<Value> items);

    Value(const Value& other);
    Value(Value&& other) noexcept;
    Value& operator=(const Value& other);
    Value& operator=(Value&& other) noexcept;
    ~Value();

    static Value array();
    static Value object();

    /// The member of that name; a new member is null. A null value becomes an object.
    Value& operator[](std::string_view key);
    const Value& at(std::string_view key) const;
    bool contains(std::string_view key) const;
    const std::vector<Member>& members() const;
    /// Adds the members of another object, or replaces those that exist.
    void update(const Value& object);

    /// Appends an item. A null value becomes an array.
    void push_back(Value item);
    Value& back();
    const Value& at(std::size_t index) const;
    std::vector<Value>::const_iterator begin() const;
    std::vector<Value>::const_iterator end() const;

    bool is_null() const { return kind == Kind::null; }
    bool is_text() const { return kind == Kind::text; }
    bool is_object() const { return kind == Kind::object; }
    bool as_bool() const;
    int as_int() const;       ///< of a number without a fraction
    double as_double() const; ///< of any number
    const std::string& as_text() const;

    /// The JSON text on one line, or with each item on its own line and `indent` spaces a level. Bytes that are not
    /// UTF-8 become U+FFFD.
    std::string dump(int indent = -1) const;

  private:
    enum class Kind { null, boolean, whole, natural, real, text, array, object };
    explicit Value(Kind kind);
    friend struct Writer;

    Kind kind = Kind::null;
    std::int64_t whole = 0; ///< of a natural number: its bits
    double real = 0;
    std::string text;
    std::vector<Value> list;
    std::vector<Member> named;
};

struct Member {
    std::string key;
    Value value;
};

} // namespace lockstone::json
