// Recordings that were cut, as by a crash or a full disk, and files that another process removes, replaces or writes.
#include "support/effort.h"
#include "support/small_recording.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

namespace fs = std::filesystem;

bool holds(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

/// A unique file name; the destructor removes the file.
struct Path {
    std::string text = (fs::temp_directory_path() /
                        ("lockstone-cut-" + std::to_string(reinterpret_cast<std::uintptr_t>(this)) + ".lsr"))
                           .string();
    Path() { fs::remove(text); }
    ~Path() { fs::remove(text); }
    Path(const Path&) = delete;
    Path& operator=(const Path&) = delete;
};

} // namespace

TEST_CASE("a recording that is cut anywhere behind its first keyframe opens and can be repaired to a "
          "complete one") {
    const SmallGame game;
    const Bytes good = record_inputs(24, {.keyframe_ticks = 10, .block_ticks = 4});
    std::uint64_t opened = 0;
    const std::size_t step = test::is_long_run() ? 1u : test::is_sanitized ? 311u : 31u;
    for (std::size_t size = 0; size < good.size(); size += step) {
        CAPTURE(size);
        const Bytes bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
        const auto cut = read(bytes, OnDamage::recover_cut);
        const auto any = read(bytes, OnDamage::recover);
        REQUIRE(cut.ok() == any.ok());
        if (!cut) continue;
        ++opened;
        CHECK(!cut->complete());
        CHECK(holds(cut->damage(), "the recording is incomplete"));
        if (cut->tick_count() == 0) continue;
        CHECK(verify(*cut, &game).verdict == Verdict::incomplete);
        MemorySink sink;
        must(repair(*cut, sink));
        const Recording whole = must(read(sink.bytes));
        CHECK(whole.end_tick() == cut->end_tick());
        CHECK(verify(whole, &game).good());
        CHECK(*find_option(whole.header(), "repaired.end") == std::to_string(cut->end_tick()));
    }
    CHECK(opened > 20);
}

TEST_CASE("the reader does not accept a recording with damage in its middle as a cut one") {
    Bytes bad = record_inputs(400, {.keyframe_ticks = 0, .block_ticks = 4});
    bad[bad.size() * 2 / 3] ^= std::byte{1};
    CHECK(!read(bad, OnDamage::recover_cut).ok());
    const Recording rest = must(read(bad, OnDamage::recover));
    MemorySink sink;
    must(repair(rest, sink)); // recovery on request keeps the ticks before the damage
    CHECK(verify(must(read(sink.bytes)),
                 [] {
                     static const SmallGame game;
                     return &game;
                 }())
              .good());
}

TEST_CASE("a file sink rejects a file that another recorder writes") {
    const Path path;
    auto first = must(FileSink::create(path.text));
    const Bytes bytes(100, std::byte{1});
    must(first.append(bytes));
    CHECK(is_being_written(path.text));
    const auto second = FileSink::create(path.text);
    REQUIRE(!second);
    CHECK(holds(second.error().message, "another recorder is writing it"));
    must(first.append(bytes)); // no bytes were lost
    CHECK(fs::file_size(path.text) == 200);
    must(first.close());
    CHECK(!is_being_written(path.text));
    CHECK(FileSink::create(path.text).ok());
    CHECK(fs::file_size(path.text) == 0);
}

TEST_CASE("a file sink reports a file that is removed or replaced or changed during writing") {
    const Bytes bytes(100, std::byte{1});
    const auto told = [&](std::string_view what, const auto& harm) {
        const Path path;
        auto sink = must(FileSink::create(path.text));
        must(sink.append(bytes));
        harm(path.text);
        const Status status = sink.append(bytes);
        return !status && holds(status.error().message, what);
    };
    CHECK(told("was removed", [](const std::string& path) { fs::remove(path); }));
    CHECK(told("was replaced", [](const std::string& path) {
        fs::remove(path);
        std::ofstream(path) << "another";
    }));
    CHECK(told("another program changed it",
               [](const std::string& path) { std::ofstream(path, std::ios::app) << "more"; }));
    CHECK(told("another program changed it", [](const std::string& path) { fs::resize_file(path, 10); }));
    CHECK(!told("", [](const std::string&) {})); // negative control: an unchanged file
}
