// Where two states part: each machine asks the other for the hashes of columns, then of the pages of the first that
// differs, then for the rows of the first page that does; and for the hashes after each phase of the tick, run again.
//
//   columns -> pages of a column -> rows of a page -> phases -> a report
//
// Each side asks for itself, one question at a time, again until it is answered. Questions are answered about the one tick
// that this machine has itself seen to differ, from a copy of the state, at most one packet a poll and 64 kB in all: whoever asks
// more, or never answers, costs no more.
#pragma once

#include "session/link/message.h"

namespace lockstone::session {

inline constexpr std::size_t inspection_bytes_max =
    64 * 1024;                                        ///< that are sent to a peer, and taken from one
inline constexpr std::size_t answer_bytes_max = 1100; ///< of content in a packet

enum class Topic : std::uint8_t { columns, pages, rows, phases };

struct Question {
    std::uint64_t tick; ///< about the state after it
    Topic topic;
    std::uint32_t column, page; ///< where the topic has them, else 0
    std::uint32_t offset;       ///< of the content's bytes

    friend bool operator==(const Question&, const Question&) = default;
};
struct Answer {
    Question to;
    std::uint32_t total; ///< bytes of the whole content
    std::span<const std::byte> bytes;
};

/// The packet of a question or an answer, as README.md specifies it.
std::span<const std::byte> write_question(std::vector<std::byte>& buffer, const PacketContext& context,
                                          const Question& question);
std::span<const std::byte> write_answer(std::vector<std::byte>& buffer, const PacketContext& context,
                                        const Answer& answer);
bool is_inspection(std::span<const std::byte> packet);
/// Fills `question`, or `answer` with views into the packet; the other is reset. Never asserts.
std::optional<PacketFault> read_inspection(std::span<const std::byte> packet, const PacketContext& context,
                                           std::optional<Question>& question, std::optional<Answer>& answer);

/// One desync with one peer, seen from this machine.
class Inspection {
  public:
    /// `after` is copied. `rerun`: the tick, run again here.
    Inspection(DesyncReport known, const State& after, Rerun rerun);

    /// What is to be sent in this poll, if anything; `answer_to` waits from then on no more.
    std::span<const std::byte> next_packet(const PacketContext& context);
    void take(const Question& question);
    void take(const Answer& answer);
    /// Once: when all is known that can be.
    std::optional<DesyncReport> take_report();
    void give_up() { topic = end; }

  private:
    static constexpr std::uint32_t end = 4; ///< after Topic::phases

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
    std::vector<std::byte> gathered; ///< the answer so far
    std::uint32_t polls_until_asked = 0, times_asked = 0;
    std::optional<Question> answer_to;
    std::vector<std::byte> packet;
    std::size_t sent = 0, taken = 0;
    bool reported = false;
};

} // namespace lockstone::session
