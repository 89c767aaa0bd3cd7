// Inspection of a desync: two machines find the first difference between their states. Each one requests the hashes
// of all columns, then those of the pages of the first different column, then the rows of the first different page,
// and then the hashes after each phase of the tick, which both run again.
//
//   columns -> pages of a column -> rows of a page -> phases -> a report
//
// Each machine has one open question at a time and repeats it until the answer arrives. It answers only questions
// about the one tick that it has itself found to differ, from a copy of the state, with at most one packet in a poll
// and 64 kB in all. So a peer that requests more, or never answers, causes no further cost.
#pragma once

#include "session/link/message.h"

namespace lockstone::session {

/// Maximum of the bytes sent to a peer, and of those received from it.
inline constexpr std::size_t inspection_bytes_max = 64 * 1024;
inline constexpr std::size_t answer_bytes_max = 1100; ///< of content in a packet

/// The content of an answer.
enum class Topic : std::uint8_t { columns, pages, rows, phases };

/// A request for a part of the content of a topic.
struct Question {
    std::uint64_t tick; ///< the state after this tick
    Topic topic;
    std::uint32_t column, page; ///< indices, for topics that have them, else 0
    std::uint32_t offset;       ///< of the first requested byte in the content

    friend bool operator==(const Question&, const Question&) = default;
};
/// An answer to a question.
struct Answer {
    Question to;
    std::uint32_t total; ///< length of the whole content [bytes]
    std::span<const std::byte> bytes;
};

/// The writers fill `buffer` with a packet in the format of README.md and return it. The view is valid
/// until the buffer changes.
std::span<const std::byte> write_question(std::vector<std::byte>& buffer, const PacketContext& context,
                                          const Question& question);
std::span<const std::byte> write_answer(std::vector<std::byte>& buffer, const PacketContext& context,
                                        const Answer& answer);
/// True if the first byte is that of a question or an answer.
bool is_inspection(std::span<const std::byte> packet);
/// Reads a question or an answer (a view into the packet); its counterpart is reset. Returns why the packet
/// is invalid; empty: it is valid. Never asserts.
std::optional<PacketFault> read_inspection(std::span<const std::byte> packet, const PacketContext& context,
                                           std::optional<Question>& question, std::optional<Answer>& answer);

/// The inspection of one desync with one peer, on this machine.
class Inspection {
  public:
    /// `known`: the report so far. `after`: the state after the tick, copied. `rerun`: result of running
    /// the tick again.
    Inspection(DesyncReport known, const State& after, Rerun rerun);

    /// The packet to send in this poll, an answer or a question; empty: none. Valid until the next call.
    std::span<const std::byte> next_packet(const PacketContext& context);
    /// Stores a question for the next packet; a question about another tick is ignored.
    void take(const Question& question);
    /// Adds a part of the answer to the open question; a complete answer leads to the next question. Other
    /// answers are ignored.
    void take(const Answer& answer);
    /// The report, exactly once, as soon as the exchange has ended.
    std::optional<DesyncReport> take_report();
    void give_up() { topic = end; }

  private:
    static constexpr std::uint32_t end = 4; ///< the topic after the last one

    void ask_next(std::uint32_t next);
    std::vector<std::byte> content(const Question& question) const;
    void read_columns();
    void read_pages();
    void read_rows();
    void read_phases();

    DesyncReport report;
    State here;
    HashTree tree;
    Rerun phases;
    std::uint32_t topic = 0;
    Question question{};
    std::vector<std::byte> gathered; ///< bytes of the answer so far
    std::uint32_t polls_until_asked = 0, times_asked = 0;
    std::optional<Question> answer_to;
    std::vector<std::byte> packet;
    std::size_t sent = 0, taken = 0;
    bool reported = false;
};

} // namespace lockstone::session
