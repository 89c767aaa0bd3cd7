// Damaged files: the reader detects damage in every byte of a recording and reports it.
#include "support/effort.h"
#include "support/small_recording.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

/// A sentence that names the file and is one line of printable text.
bool is_sentence(const std::string& text) {
    const bool printable =
        std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) >= 0x20; });
    return text.starts_with("test.lsr: ") && text.size() > 30 && printable;
}

/// Requires that a strict read refuses the bytes, and that recovery refuses them or marks the recording as damaged.
void check_refused(const Bytes& bytes, std::size_t where) {
    CAPTURE(where);
    const auto strict = read(bytes);
    REQUIRE(!strict);
    REQUIRE_MESSAGE(is_sentence(strict.error().message), strict.error().message);
    const auto recovered = read(bytes, OnDamage::recover);
    if (!recovered) return;
    REQUIRE(!recovered->complete());
    REQUIRE(recovered->damage() == strict.error().message);
}

void check_every_flip(const Bytes& good) {
    REQUIRE(read(good).ok());
    for (std::size_t at = 0; at < good.size(); ++at) {
        for (const unsigned change : {0x01u, 0x10u, 0x80u, 0xffu}) {
            if (test::is_too_long_here() && (at + change) % 8 != 0) continue;
            Bytes bad = good;
            bad[at] ^= static_cast<std::byte>(change);
            check_refused(bad, at);
        }
    }
}

} // namespace

TEST_CASE("the reader rejects a recording of inputs or commands with any flipped byte with a sentence") {
    check_every_flip(record_inputs(6, {.options = {{"seed", "7"}}, .keyframe_ticks = 4, .block_ticks = 2}));
    check_every_flip(record_commands(6, {.keyframe_ticks = 4, .block_ticks = 2}));
}

TEST_CASE("the reader rejects a recording that is cut at any byte and recovers its whole chunks which still "
          "verify") {
    const SmallGame game;
    const Bytes good = record_inputs(12, {.keyframe_ticks = 6, .block_ticks = 2});
    const std::uint64_t whole_ticks = must(read(good)).tick_count();
    std::uint64_t ticks_before = 0;
    std::size_t recovered_files = 0;
    for (std::size_t size = 0; size < good.size(); ++size) {
        const Bytes bad(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
        check_refused(bad, size);
        const auto recovered = read(bad, OnDamage::recover);
        if (!recovered) continue;
        ++recovered_files;
        REQUIRE(recovered->tick_count() >= ticks_before);
        if (recovered->tick_count() != ticks_before || size + 1 == good.size()) {
            ticks_before = recovered->tick_count();
            const VerifyReport report = verify(*recovered, &game);
            REQUIRE(report.verdict == Verdict::incomplete);
            REQUIRE(report.ticks == recovered->tick_count());
            REQUIRE(is_sentence(report.sentence));
            REQUIRE(must(Player::open(*recovered, game)).seek(recovered->end_tick()).ok());
        }
    }
    CHECK(ticks_before == whole_ticks);
    CHECK(recovered_files > 300);
}

TEST_CASE("the reader rejects one or many bytes after the end of a recording") {
    const Bytes good = record_inputs(3);
    for (const std::size_t more : {1u, 7u, 16u, 24u, 5000u}) {
        Bytes bad = good;
        bad.insert(bad.end(), more, std::byte{0});
        check_refused(bad, good.size());
    }
    Bytes twice = good;
    twice.insert(twice.end(), good.begin(), good.end());
    check_refused(twice, good.size());
}

TEST_CASE("the reader rejects a file that is not a recording with the reason") {
    const auto message = [](std::string_view text) {
        const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
        return read(Bytes(bytes.begin(), bytes.end())).error().message;
    };
    CHECK(message("") == "test.lsr: the file is empty, it should be a recording (.lsr)");
    CHECK(message("\x89PNG\r\n\x1a\n................") ==
          "test.lsr: this is not a recording: it does not begin with the eight bytes of .lsr files");
    CHECK(message("hello") ==
          "test.lsr: this is not a recording: it does not begin with the eight bytes of .lsr files");
    CHECK(message(std::string(100000, '\0')) ==
          "test.lsr: this is not a recording: it does not begin with the eight bytes of .lsr files");
    CHECK(message("\x89LSR\r\n\x1a\n") == "test.lsr: the recording is cut at byte 8, inside the preamble");
    CHECK(message(std::string_view("\x89LSR\r\n\x1a\n\5\0\0\0\0\0\0\0", 16)) ==
          "test.lsr: the recording is of format version 5, this reader knows version 6");
}

TEST_CASE("the reader rejects a path that it cannot read with the system's reason") {
    CHECK(Recording::open("/no/such/file.lsr").error().message ==
          "/no/such/file.lsr: cannot open the file: No such file or directory");
    CHECK(Recording::open("/").error().message == "/: cannot read the file at byte 0: Is a directory");
    CHECK(Recording::open("/dev/zero").error().message ==
          "/dev/zero: this is not a recording: it does not begin with the eight bytes of .lsr files");
}

TEST_CASE("the reader rejects a chunk that claims a huge size") {
    const Bytes good = record_inputs(3);
    const auto chunks = chunks_of(good);
    std::size_t at = preamble_bytes;
    for (const Chunk& chunk : chunks) {
        for (const std::uint64_t size : {std::uint64_t{1} << 63, ~std::uint64_t{0}, ~std::uint64_t{0} - 23,
                                         std::uint64_t{good.size()}, std::uint64_t{1} << 32}) {
            Bytes bad = good;
            base::store_little_endian(size, bad.data() + at + 8);
            check_refused(bad, at);
        }
        at += chunk_head_bytes + chunk.payload.size() + checksum_bytes;
    }
}

TEST_CASE("a huge number anywhere under valid checksums is rejected with a sentence or fails to verify") {
    const SmallGame game;
    const auto chunks = chunks_of(record_inputs(3));
    REQUIRE(verify(must(read(file_of(chunks, true))), &game).good());
    int refused = 0, read_but_bad = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        if (chunks[i].type == chunk_index || chunks[i].type == chunk_end)
            continue; // file_of() writes these chunks again
        for (std::size_t k = 0; k + 8 <= chunks[i].payload.size(); k += 4) {
            INFO("chunk ", chunk_name(chunks[i].type), ", byte ", k);
            auto bad = chunks;
            base::store_little_endian(std::uint64_t{1} << 63 | 0x7fffffffu, bad[i].payload.data() + k);
            const auto result = read(file_of(bad, true));
            if (result) {
                const VerifyReport report = verify(*result, &game);
                REQUIRE(!report.good());
                REQUIRE(is_sentence(report.sentence));
                ++read_but_bad;
            } else {
                REQUIRE(is_sentence(result.error().message));
                ++refused;
            }
        }
    }
    CHECK(refused > 0);
    CHECK(read_but_bad > 0); // a reader accepts any image and hash of a start
}

TEST_CASE("the reader rejects announced sizes before it allocates memory of this size") {
    const auto chunks = chunks_of(record_inputs(3));
    const auto with_u64 = [&](std::uint32_t type, std::size_t at, std::uint64_t value) {
        auto bad = chunks;
        base::store_little_endian(value, bad[find_chunk(bad, type)].payload.data() + at);
        return read(file_of(bad, true)).error().message;
    };
    CHECK(with_u64(chunk_ticks, 12, std::uint64_t{1} << 63)
              .find("the unpacked size is 9223372036854775808, at most 67108864") != std::string::npos);
    CHECK(with_u64(chunk_ticks, 12, std::uint64_t{1} << 26).find("cannot hold as many bytes as that") !=
          std::string::npos);
    CHECK(with_u64(chunk_keyframe, 16, std::uint64_t{1} << 63)
              .find("the image has 9223372036854775808 bytes") != std::string::npos);
    CHECK(with_u64(chunk_keyframe, 16, std::uint64_t{1} << 31).find("cannot hold as many bytes as that") !=
          std::string::npos);
}

TEST_CASE("a chunk that is removed or repeated or swapped or from another recording breaks the chain of "
          "checksums") {
    const Bytes good = record_inputs(12, {.keyframe_ticks = 6, .block_ticks = 2});
    const Bytes other = record_commands(12, {.keyframe_ticks = 6, .block_ticks = 2});
    std::vector<std::size_t> starts;
    for (std::size_t at = preamble_bytes; const Chunk& chunk : chunks_of(good)) {
        starts.push_back(at);
        at += chunk_head_bytes + chunk.payload.size() + checksum_bytes;
    }
    starts.push_back(good.size());
    const auto piece = [&](std::size_t i) {
        return std::span(good).subspan(starts[i], starts[i + 1] - starts[i]);
    };
    for (std::size_t skip = 0; skip + 1 < starts.size(); ++skip) {
        Bytes removed(good.begin(), good.begin() + preamble_bytes), repeated = removed, swapped = removed;
        for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
            const auto add = [&](Bytes& to, std::size_t k) {
                to.insert(to.end(), piece(k).begin(), piece(k).end());
            };
            if (i != skip) add(removed, i);
            add(repeated, i);
            if (i == skip) add(repeated, i);
            const bool has_next = skip + 2 < starts.size();
            add(swapped, has_next && i == skip ? i + 1 : has_next && i == skip + 1 ? i - 1 : i);
        }
        check_refused(removed, starts[skip]);
        check_refused(repeated, starts[skip]);
        if (skip + 2 < starts.size()) check_refused(swapped, starts[skip]);
    }
    Bytes mixed(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(starts[3]));
    mixed.insert(mixed.end(), other.begin() + static_cast<std::ptrdiff_t>(starts[3]), other.end());
    check_refused(mixed, starts[3]);
}

TEST_CASE("the reader accepts a newer minor version and skips its chunks only if they are marked skippable") {
    auto chunks = chunks_of(record_inputs(4, {.keyframe_ticks = 2}));
    const auto whole = must(read(file_of(chunks, true)));
    for (std::size_t at = 1; at + 1 < chunks.size(); ++at) {
        auto with_new = chunks;
        with_new.insert(with_new.begin() + static_cast<std::ptrdiff_t>(at),
                        {chunk_type("NEWS"), flag_skippable, Bytes(5)});
        const auto skipped = read(file_of(with_new, true, version_minor + 1));
        REQUIRE_MESSAGE(skipped.ok(), skipped.error().message);
        CHECK(skipped->tick_count() == whole.tick_count());
        with_new[at].flags = 0;
        const auto refused = read(file_of(with_new, true, version_minor + 1));
        REQUIRE(!refused);
        CHECK(refused.error().message.find("chunk NEWS at byte ") != std::string::npos);
        CHECK(refused.error().message.find("is not marked skippable") != std::string::npos);
    }
    auto marked = chunks;
    marked[find_chunk(marked, chunk_ticks)].flags = flag_skippable;
    CHECK(!read(file_of(marked, true)));
    marked[find_chunk(marked, chunk_ticks)].flags = 2;
    CHECK(!read(file_of(marked, true)));
}

TEST_CASE("the reader rejects missing and repeated and swapped chunks under valid checksums") {
    const auto chunks = chunks_of(record_inputs(8, {.keyframe_ticks = 4, .block_ticks = 2}));
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        auto removed = chunks;
        removed.erase(removed.begin() + static_cast<std::ptrdiff_t>(i));
        const bool optional = chunks[i].type == chunk_keyframe && i != find_chunk(chunks, chunk_keyframe);
        CHECK_MESSAGE(read(file_of(removed, true)).ok() == optional, "without chunk ", i, " ",
                      chunk_name(chunks[i].type));
        auto repeated = chunks;
        repeated.insert(repeated.begin() + static_cast<std::ptrdiff_t>(i), chunks[i]);
        CHECK_MESSAGE(!read(file_of(repeated, true)), "chunk ", i, " twice");
        if (i + 1 == chunks.size()) continue;
        auto swapped = chunks;
        std::swap(swapped[i], swapped[i + 1]);
        CHECK_MESSAGE(!read(file_of(swapped, true)), "chunks ", i, " and ", i + 1, " swapped");
    }
}
