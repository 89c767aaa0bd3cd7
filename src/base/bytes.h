// Reads and writes little-endian bytes; all files and packets use it.
//
//   ByteReader in(packet, "input packet");
//   const std::uint32_t tick = in.u32("tick");
//   const auto inputs = in.bytes(in.u16("input length"), "inputs");
//   if (!in.ok()) return in.error();      // "input packet: inputs needs 40 bytes, only 12 remain (at byte 6)"
//
// A read past the end never asserts: it returns zeros (or an empty span), and the reader keeps the first error. So
// the caller reads a whole header, then checks once before it uses any value.
#pragma once

#include "base/text.h"
#include "lockstone/result.h"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::base {

template <std::unsigned_integral N> constexpr void store_little_endian(N value, std::byte* to) {
    for (std::size_t i = 0; i < sizeof(N); ++i)
        to[i] =
            static_cast<std::byte>(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
}
template <std::unsigned_integral N> constexpr N load_little_endian(const std::byte* from) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(N); ++i) value |= static_cast<std::uint64_t>(from[i]) << (8 * i);
    return static_cast<N>(value);
}

/// Appends to a vector, which the caller owns and which must outlive the writer.
class ByteWriter {
  public:
    explicit ByteWriter(std::vector<std::byte>& to) : out(to) {}

    void u8(std::uint8_t v) { append(v); }
    void u16(std::uint16_t v) { append(v); }
    void u32(std::uint32_t v) { append(v); }
    void u64(std::uint64_t v) { append(v); }
    void i32(std::int32_t v) { append(static_cast<std::uint32_t>(v)); }
    void i64(std::int64_t v) { append(static_cast<std::uint64_t>(v)); }
    void bytes(std::span<const std::byte> v) {
        // Not insert(): g++ 12 warns of an overflow in it that cannot happen.
        const std::size_t at = out.size();
        out.resize(at + v.size());
        if (!v.empty()) std::memcpy(out.data() + at, v.data(), v.size());
    }
    /// LEB128: seven bits per byte, the lowest first; the high bit is set if another byte follows.
    void varint(std::uint64_t v) {
        for (; v >= 0x80; v >>= 7) u8(static_cast<std::uint8_t>(v | 0x80));
        u8(static_cast<std::uint8_t>(v));
    }
    /// A u32 length, then the bytes of the text.
    void text(std::string_view v) {
        u32(static_cast<std::uint32_t>(v.size()));
        bytes(std::as_bytes(std::span(v.data(), v.size())));
    }
    /// Bytes in the vector, including those from before the writer.
    std::size_t size() const { return out.size(); }
    /// Overwrites a u64 written earlier, for sizes that are known only at the end.
    void patch_u64(std::size_t offset, std::uint64_t v) { store_little_endian(v, out.data() + offset); }

  private:
    template <std::unsigned_integral N> void append(N v) {
        std::byte little[sizeof(N)];
        store_little_endian(v, little);
        bytes(little);
    }
    std::vector<std::byte>& out;
};

/// Reads untrusted bytes, which it does not own. The error sentence contains `subject` and `what`.
class ByteReader {
  public:
    ByteReader(std::span<const std::byte> from, std::string_view subject) : data(from), name(subject) {}

    std::uint8_t u8(std::string_view what) { return take<std::uint8_t>(what); }
    std::uint16_t u16(std::string_view what) { return take<std::uint16_t>(what); }
    std::uint32_t u32(std::string_view what) { return take<std::uint32_t>(what); }
    std::uint64_t u64(std::string_view what) { return take<std::uint64_t>(what); }
    std::int32_t i32(std::string_view what) { return static_cast<std::int32_t>(take<std::uint32_t>(what)); }
    std::int64_t i64(std::string_view what) { return static_cast<std::int64_t>(take<std::uint64_t>(what)); }
    /// Reads a number that ByteWriter::varint wrote; fails if the number does not fit into 64 bits.
    std::uint64_t varint(std::string_view what) {
        std::uint64_t value = 0;
        for (unsigned shift = 0;; shift += 7) {
            const std::uint64_t byte = u8(what);
            if (failed) return 0;
            const std::uint64_t bits = byte & 0x7f;
            if (shift == 63 && byte > 1) {
                fail_at(position - 1, join(what, " has more than 64 bits"));
                return 0;
            }
            value |= bits << shift;
            if (byte < 0x80) return value;
        }
    }
    /// A view of the next `size` bytes; empty if fewer remain. Any size is safe.
    std::span<const std::byte> bytes(std::uint64_t size, std::string_view what) {
        if (failed) return {};
        if (size > remaining()) {
            fail(join(what, " needs ", size, " bytes, only ", remaining(), " remain"));
            return {};
        }
        const auto view = data.subspan(position, static_cast<std::size_t>(size));
        position += view.size();
        return view;
    }
    /// Reads a text that ByteWriter::text wrote. Returns a view into the bytes.
    std::string_view text(std::string_view what) {
        const auto view = bytes(u32(what), what);
        return {reinterpret_cast<const char*>(view.data()), view.size()};
    }

    std::size_t offset() const { return position; }
    std::size_t remaining() const { return failed ? 0 : data.size() - position; }
    /// Fails if bytes remain.
    void expect_end() {
        if (remaining() != 0) fail(join("ends here, but ", remaining(), " bytes follow"));
    }
    /// Records "<subject>: <sentence> (at byte <offset>)" unless there is an error already.
    void fail(std::string_view sentence) { fail_at(position, sentence); }
    void fail_at(std::size_t at, std::string_view sentence) {
        if (failed) return;
        failed = true;
        message = join(name, ": ", sentence, " (at byte ", at, ")");
    }

    bool ok() const { return !failed; }
    /// The first error; valid only if !ok().
    Error error() const { return {message}; }

  private:
    template <std::unsigned_integral N> N take(std::string_view what) {
        const auto view = bytes(sizeof(N), what);
        return view.empty() ? N{0} : load_little_endian<N>(view.data());
    }
    std::span<const std::byte> data;
    std::string_view name;
    std::size_t position = 0;
    bool failed = false;
    std::string message;
};

} // namespace lockstone::base
