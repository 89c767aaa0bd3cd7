// Packets that wait, in memory taken once: what does not fit is refused.
#pragma once

#include "net/crypto.h"

#include <cstring>

namespace lockstone::net {

/// Label: where a packet goes or comes from.
template <class Label> class PacketQueue {
  public:
    PacketQueue(std::size_t packets_max, std::size_t bytes_max) : entries(packets_max), bytes(bytes_max) {}

    /// Space for one packet, to be filled at once; empty when there is none.
    Space push(const Label& label, std::size_t size) {
        if (first == count) first = count = used = 0;
        if (count == entries.size() || size > bytes.size() - used) return {};
        entries[count++] = {label, used, size};
        used += size;
        return Space(bytes).subspan(used - size, size);
    }
    bool push_copy(const Label& label, Bytes packet) {
        const Space to = push(label, packet.size());
        if (to.size() != packet.size()) return false;
        if (!packet.empty()) std::memcpy(to.data(), packet.data(), packet.size());
        return true;
    }
    /// Takes back what was pushed last.
    void drop_last() { used = entries[--count].at; }

    struct Entry {
        Label label;
        std::size_t at, size;
    };
    /// The oldest; its bytes are valid until the next push.
    const Entry* pop() { return first == count ? nullptr : &entries[first++]; }
    Bytes bytes_of(const Entry& entry) const { return Bytes(bytes).subspan(entry.at, entry.size); }

  private:
    std::vector<Entry> entries;
    std::vector<std::byte> bytes;
    std::size_t first = 0, count = 0, used = 0;
};

/// Space for a datagram, which is counted; empty where the queue is full.
inline Space push_counted(PacketQueue<NetAddress>& outgoing, NetStats& stats, const NetAddress& to,
                          std::size_t size) {
    const Space space = outgoing.push(to, size);
    if (space.empty()) {
        ++stats.queue_full;
        return {};
    }
    ++stats.sent, stats.bytes_sent += size;
    return space;
}

} // namespace lockstone::net
