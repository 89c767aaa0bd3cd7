#include "replay/format/pack.h"

#include "base/text.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

constexpr std::size_t run_min = 3, run_max = 130, literals_max = 128;
constexpr std::uint8_t run_bias = 125; ///< control byte - bias = length of the run

std::size_t run_length(std::span<const std::byte> bytes, std::size_t at) {
    const std::size_t end = std::min(bytes.size(), at + run_max);
    std::size_t i = at + 1;
    while (i < end && bytes[i] == bytes[at]) ++i;
    return i - at;
}

void append_literals(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
    while (!bytes.empty()) {
        const std::size_t n = std::min(bytes.size(), literals_max);
        out.push_back(static_cast<std::byte>(n - 1));
        out.insert(out.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
        bytes = bytes.subspan(n);
    }
}

} // namespace

void pack(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
    std::size_t literals_from = 0, at = 0;
    while (at < bytes.size()) {
        const std::size_t run = run_length(bytes, at);
        if (run >= run_min) {
            append_literals(bytes.subspan(literals_from, at - literals_from), out);
            out.push_back(static_cast<std::byte>(run + run_bias));
            out.push_back(bytes[at]);
            literals_from = at + run;
        }
        at += run;
    }
    append_literals(bytes.subspan(literals_from), out);
}

namespace {

/// Calls run(byte, count) and literals(bytes) in order, up to the first fault; never passes on more than `size`
/// bytes.
template <class Run, class Literals>
Status walk(std::span<const std::byte> packed, std::uint64_t size, Run&& run, Literals&& literals) {
    const auto wrong = [&](std::string_view how) {
        return Error{base::join("the ", packed.size(), " packed bytes ", how, ", ", size, " are announced")};
    };
    if (size > packed.size() * unpack_ratio_max) return wrong("cannot hold as many bytes as that");
    std::uint64_t done = 0;
    for (std::size_t at = 0; at < packed.size();) {
        const auto control = std::to_integer<std::size_t>(packed[at++]);
        const bool is_run = control >= literals_max;
        const std::size_t yields = is_run ? control - run_bias : control + 1;
        const std::size_t takes = is_run ? 1 : yields;
        if (takes > packed.size() - at) return wrong("end in the middle of a stretch");
        if (yields > size - done) return wrong("hold more bytes");
        if (is_run)
            run(packed[at], yields);
        else
            literals(packed.subspan(at, takes));
        at += takes;
        done += yields;
    }
    if (done != size) return wrong(base::join("hold ", done, " bytes"));
    return {};
}

} // namespace

Status check_packed(std::span<const std::byte> packed, std::uint64_t size) {
    return walk(
        packed, size, [](std::byte, std::size_t) {}, [](std::span<const std::byte>) {});
}

Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, std::uint64_t size) {
    std::vector<std::byte> out;
    if (size <= packed.size() * unpack_ratio_max) out.reserve(static_cast<std::size_t>(size));
    const Status status = walk(
        packed, size, [&](std::byte b, std::size_t count) { out.insert(out.end(), count, b); },
        [&](std::span<const std::byte> from) { out.insert(out.end(), from.begin(), from.end()); });
    if (!status) return status.error();
    return out;
}

void append_planes(std::span<const std::byte> table, std::size_t row_bytes, std::vector<std::byte>& out) {
    if (row_bytes == 0) return;
    const std::size_t rows = table.size() / row_bytes;
    for (std::size_t column = 0; column < row_bytes; ++column) {
        std::byte before{};
        for (std::size_t row = 0; row < rows; ++row) {
            const std::byte now = table[row * row_bytes + column];
            out.push_back(now ^ before);
            before = now;
        }
    }
}

std::vector<std::byte> read_planes(std::span<const std::byte> planes, std::size_t row_bytes) {
    std::vector<std::byte> table(planes.size());
    const std::size_t rows = row_bytes == 0 ? 0 : planes.size() / row_bytes;
    for (std::size_t column = 0; column < row_bytes; ++column) {
        std::byte before{};
        for (std::size_t row = 0; row < rows; ++row) {
            before ^= planes[column * rows + row];
            table[row * row_bytes + column] = before;
        }
    }
    return table;
}

} // namespace lockstone::replay
