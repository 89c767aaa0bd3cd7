// A queue of packets with fixed memory: a full queue refuses further packets.
#pragma once

#include "net/crypto.h"

#include <cstring>

namespace lockstone::net {

/// `Label`: receiver or sender of a packet.
template <class Label> class PacketQueue {
  public:
    PacketQueue(std::size_t packets_max, std::size_t bytes_max) : entries(packets_max), bytes(bytes_max) {}

    /// Reserves space for one packet; the caller fills it before the next call. Empty: the queue is full.
    Space push(const Label& label, std::size_t size) {
        if (first == count) first = count = used = 0;
        if (count == entries.size() || size > bytes.size() - used) return {};
        entries[count++] = {label, used, size};
        used += size;
        return Space(bytes).subspan(used - size, size);
    }
    /// Adds a copy of a packet; false: the queue is full.
    bool push_copy(const Label& label, Bytes packet) {
        const Space to = push(label, packet.size());
        if (to.size() != packet.size()) return false;
        if (!packet.empty()) std::memcpy(to.data(), packet.data(), packet.size());
        return true;
    }
    /// Removes the packet that was added last.
    void drop_last() { used = entries[--count].at; }

    struct Entry {
        Label label;
        std::size_t at, size;
    };
    /// Removes and returns the oldest packet; null: none. Its bytes are valid until the next push.
    const Entry* pop() { return first == count ? nullptr : &entries[first++]; }
    Bytes bytes_of(const Entry& entry) const { return Bytes(bytes).subspan(entry.at, entry.size); }

  private:
    std::vector<Entry> entries;
    std::vector<std::byte> bytes;
    std::size_t first = 0, count = 0, used = 0;
};

/// Reserves space for a datagram and counts it; empty: the queue is full.
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
