#include "session/desync/inspection.h"

#include "base/bytes.h"
#include "base/text.h"

#include <algorithm>

namespace lockstone::session {

// ---- packets -----------------------------------------------------------------------------------------------------

namespace {

constexpr std::byte question_kind{0x51}, answer_kind{0x41}; // "Q", "A"

void write_head(std::vector<std::byte>& buffer, std::byte kind, const PacketContext& context,
                const Question& about) {
    buffer.clear();
    buffer.reserve(packet_bytes_max);
    base::ByteWriter out(buffer);
    out.u8(std::to_integer<std::uint8_t>(kind));
    out.u8(static_cast<std::uint8_t>(about.topic));
    out.u32(context.match);
    out.u32(static_cast<std::uint32_t>(about.tick));
    out.u32(about.column);
    out.u32(about.page);
    out.u32(about.offset);
}

} // namespace

std::span<const std::byte> write_question(std::vector<std::byte>& buffer, const PacketContext& context,
                                          const Question& question) {
    write_head(buffer, question_kind, context, question);
    return add_checksum(buffer);
}

std::span<const std::byte> write_answer(std::vector<std::byte>& buffer, const PacketContext& context,
                                        const Answer& answer) {
    write_head(buffer, answer_kind, context, answer.to);
    base::ByteWriter out(buffer);
    out.u32(answer.total);
    out.bytes(answer.bytes);
    return add_checksum(buffer);
}

bool is_inspection(std::span<const std::byte> packet) {
    return !packet.empty() && (packet[0] == question_kind || packet[0] == answer_kind);
}

std::optional<PacketFault> read_inspection(std::span<const std::byte> packet, const PacketContext& context,
                                           std::optional<Question>& question, std::optional<Answer>& answer) {
    question.reset(), answer.reset();
    const std::span<const std::byte> body = checked_body(packet);
    if (body.empty()) return PacketFault::damaged;
    base::ByteReader in(body, "inspection");
    const bool is_answer = in.u8("kind") == std::to_integer<std::uint8_t>(answer_kind);
    const std::uint32_t topic = in.u8("topic");
    if (in.u32("match") != context.match) return PacketFault::match;
    Question about{in.u32("tick"), static_cast<Topic>(topic), in.u32("column"), in.u32("page"),
                   in.u32("offset")};
    if (topic > static_cast<std::uint32_t>(Topic::phases)) in.fail("no such topic");
    if (about.offset > inspection_bytes_max) in.fail("offset out of range");
    if (is_answer) {
        const std::uint32_t total = in.u32("total");
        const std::span<const std::byte> bytes = in.bytes(in.remaining(), "content");
        if (total > inspection_bytes_max || bytes.size() > answer_bytes_max ||
            about.offset + bytes.size() > total)
            in.fail("content out of range");
        answer = Answer{about, total, bytes};
    } else {
        question = about;
    }
    in.expect_end();
    if (in.ok()) return std::nullopt;
    question.reset(), answer.reset();
    return PacketFault::malformed;
}

// ---- answers -----------------------------------------------------------------------------------------------------

Inspection::Inspection(DesyncReport known, const State& after, Rerun rerun)
    : report(std::move(known)), here(after), tree(here.hash_tree()), phases(std::move(rerun)) {
    ask_next(0);
}

void Inspection::take(const Question& asked) {
    if (asked.tick == report.tick) answer_to = asked;
}

std::vector<std::byte> Inspection::content(const Question& asked) const {
    std::vector<std::byte> bytes;
    base::ByteWriter out(bytes);
    const bool is_column = asked.column < tree.columns.size();
    if (asked.topic == Topic::columns) {
        for (std::uint32_t table = 0; table < here.layout().tables().size(); ++table)
            out.u32(here.count({table}));
        for (const std::uint64_t hash : tree.columns) out.u64(hash);
    } else if (asked.topic == Topic::pages && is_column) {
        for (const std::uint64_t hash : tree.pages[asked.column]) out.u64(hash);
    } else if (asked.topic == Topic::rows && is_column && asked.page < tree.pages[asked.column].size()) {
        const ColumnInfo& column = here.layout().columns()[asked.column];
        const std::size_t page_bytes = std::size_t{column.rows_per_page} * column.row_size;
        std::span<const std::byte> rows = here.bytes(asked.column).subspan(asked.page * page_bytes);
        rows = rows.first(std::min(rows.size(), page_bytes));
        for (; !rows.empty(); rows = rows.subspan(column.row_size))
            append_canonical(rows.first(column.row_size), column.leaves, bytes);
    } else if (asked.topic == Topic::phases) {
        out.u64(report.local);
        out.u64(phases.hash);
        for (const PhaseHash& phase : phases.phases) out.u64(phase.hash);
    }
    bytes.resize(std::min(bytes.size(), inspection_bytes_max));
    return bytes;
}

std::span<const std::byte> Inspection::next_packet(const PacketContext& context) {
    if (sent >= inspection_bytes_max) return {};
    if (answer_to) {
        const Question to = *std::exchange(answer_to, std::nullopt);
        const std::vector<std::byte> whole = content(to);
        if (to.offset <= whole.size()) {
            const std::span<const std::byte> rest = std::span(whole).subspan(to.offset);
            write_answer(packet, context,
                         {to, static_cast<std::uint32_t>(whole.size()),
                          rest.first(std::min(rest.size(), answer_bytes_max))});
            sent += packet.size();
            return packet;
        }
    }
    constexpr std::uint32_t polls_between = 15, times_max = 40;
    if (topic == end || polls_until_asked-- > 0) return {};
    polls_until_asked = polls_between;
    if (++times_asked > times_max) return give_up(), std::span<const std::byte>();
    write_question(packet, context, question);
    sent += packet.size();
    return packet;
}

// ---- questions ---------------------------------------------------------------------------------------------------

void Inspection::ask_next(std::uint32_t next) {
    topic = next;
    gathered.clear();
    question = {report.tick, static_cast<Topic>(next), question.column, question.page, 0};
    polls_until_asked = times_asked = 0;
}

void Inspection::take(const Answer& answer) {
    taken += answer.bytes.size();
    if (topic == end || answer.to != question) return;
    if (taken > inspection_bytes_max) return give_up();
    gathered.insert(gathered.end(), answer.bytes.begin(), answer.bytes.end());
    if (gathered.size() < answer.total && !answer.bytes.empty()) {
        question.offset = static_cast<std::uint32_t>(gathered.size());
        polls_until_asked = times_asked = 0;
        return;
    }
    switch (static_cast<Topic>(topic)) {
    case Topic::columns:
        return read_columns();
    case Topic::pages:
        return read_pages();
    case Topic::rows:
        return read_rows();
    case Topic::phases:
        return read_phases();
    }
}

void Inspection::read_columns() {
    constexpr std::uint32_t phases_next = static_cast<std::uint32_t>(Topic::phases);
    base::ByteReader in(gathered, "columns");
    const StateLayout& layout = here.layout();
    for (std::uint32_t table = 0; table < layout.tables().size(); ++table) {
        const std::uint32_t ours = here.count({table}), theirs = in.u32("row count");
        if (in.ok() && ours != theirs)
            report.differences.push_back(
                {layout.tables()[table].name, 0, row_count_field, base::join(ours), base::join(theirs)});
    }
    for (std::uint32_t column = 0; column < tree.columns.size(); ++column) {
        const std::uint64_t theirs = in.u64("column hash");
        if (!in.ok() || theirs == tree.columns[column]) continue;
        if (report.columns.empty()) question.column = column;
        report.columns.push_back(layout.columns()[column].name);
    }
    ask_next(report.columns.empty() ? phases_next : static_cast<std::uint32_t>(Topic::pages));
}

void Inspection::read_pages() {
    base::ByteReader in(gathered, "pages");
    for (std::uint32_t page = 0; page < tree.pages[question.column].size(); ++page) {
        const std::uint64_t theirs = in.u64("page hash");
        if (!in.ok()) break;
        if (theirs == tree.pages[question.column][page]) continue;
        question.page = page;
        return ask_next(static_cast<std::uint32_t>(Topic::rows));
    }
    ask_next(static_cast<std::uint32_t>(Topic::phases)); // only row counts differ
}

void Inspection::read_rows() {
    const ColumnInfo& column = here.layout().columns()[question.column];
    const std::size_t first = std::size_t{question.page} * column.rows_per_page;
    const std::size_t rows =
        std::min(here.bytes(question.column).size() / column.row_size - first,
                 std::min<std::size_t>(column.rows_per_page, gathered.size() / column.row_size));
    if (rows > 0) {
        State there = here;
        const std::span<std::byte> to = there.edit_bytes(question.column, static_cast<std::uint32_t>(first),
                                                         static_cast<std::uint32_t>(rows));
        for (std::size_t at = 0; at < to.size(); at += column.row_size)
            read_canonical(std::span(gathered).subspan(at, column.row_size), column.leaves,
                           to.subspan(at, column.row_size));
        for (Difference& found : State::diff(here, there, desync_differences_max))
            report.differences.push_back(std::move(found));
    }
    ask_next(static_cast<std::uint32_t>(Topic::phases));
}

/// Both machines have run the tick again from equal states, so the first phase with different hashes is the
/// first difference, provided that the second run repeats the first.
void Inspection::read_phases() {
    base::ByteReader in(gathered, "phases");
    report.remote = in.u64("hash");
    const std::uint64_t again = in.u64("hash of the tick run again");
    report.local_repeats = phases.hash == report.local;
    report.remote_repeats = in.ok() && again == report.remote;
    for (const PhaseHash& phase : phases.phases) {
        const std::uint64_t theirs = in.u64("phase hash");
        if (!in.ok()) break;
        if (theirs == phase.hash) continue;
        report.phase = phase.phase;
        break;
    }
    report.complete = in.ok();
    ask_next(end);
}

std::optional<DesyncReport> Inspection::take_report() {
    if (topic != end || std::exchange(reported, true)) return std::nullopt;
    report.bytes_exchanged = sent + taken;
    return report;
}

} // namespace lockstone::session

namespace lockstone {

namespace {

/// The lowest `count` hexadecimal digits, as in "0000beef".
std::string hex_digits(std::uint64_t v, std::size_t count) {
    std::string digits(count, '0');
    for (std::size_t i = count; i > 0; --i, v >>= 4) digits[i - 1] = "0123456789abcdef"[v & 15u];
    return digits;
}

} // namespace

std::string to_string(const DesyncReport& report) {
    std::string out = base::join("tick ", report.tick, ", machine ", report.peer + 1, ": ");
    if (!report.phase.empty()) out += base::join("phase ", report.phase, ", ");
    if (!report.differences.empty())
        out += to_string(report.differences.front());
    else
        out += base::join("hash ", hex_digits(report.local, 16), " against ", hex_digits(report.remote, 16),
                          ", no field is known");
    if (report.columns.size() > 1) out += base::join(", and ", report.columns.size() - 1, " more columns");
    if (!report.complete) return out;
    if (!report.local_repeats) out += "; run again, the tick comes out differently here";
    if (!report.remote_repeats) out += "; run again, the tick comes out differently there";
    return out;
}

std::string log_text(const DesyncReport& report) {
    std::string out = to_string(report) + "\n";
    for (const Difference& difference : report.differences) out += "  " + to_string(difference) + "\n";
    for (const std::string& column : report.columns) out += "  differs: column " + column + "\n";
    for (const DesyncReport::Tick& tick : report.log) {
        out += base::join("  tick ", tick.tick, ": lower half of the hash ", hex_digits(tick.local, 8),
                          " against ", hex_digits(tick.remote, 8), ", inputs");
        for (const std::vector<std::byte>& input : tick.inputs) {
            out += " ";
            for (const std::byte b : input) {
                out += "0123456789abcdef"[std::to_integer<std::size_t>(b) >> 4];
                out += "0123456789abcdef"[std::to_integer<std::size_t>(b) & 15];
            }
        }
        out += "\n";
    }
    return out;
}

} // namespace lockstone
