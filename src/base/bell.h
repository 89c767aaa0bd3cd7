// Sleeping until a number is another one, for threads that have looked at it in vain for a while.
//
//   number.store(7), bell.ring_all(number);          // first the number, then the bell
//   bell.wait(number, seen);                         // comes back at once where it is not `seen` any more
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <type_traits>

namespace lockstone::base {

/// What the system offers.
class SystemBell {
  public:
    void wait(const std::atomic<std::uint32_t>& number, std::uint32_t seen) {
        number.wait(seen, std::memory_order_acquire);
    }
    void ring_one(std::atomic<std::uint32_t>& number) { number.notify_one(); }
    void ring_all(std::atomic<std::uint32_t>& number) { number.notify_all(); }
};

/// With a lock of its own. Who rings has changed the number and then takes the lock, so whoever compared it before is asleep
/// by then, and is woken.
class LockedBell {
  public:
    void wait(const std::atomic<std::uint32_t>& number, std::uint32_t seen) {
        std::unique_lock hold(guard);
        rung.wait(hold, [&] { return number.load(std::memory_order_acquire) != seen; });
    }
    void ring_one(std::atomic<std::uint32_t>&) {
        { const std::lock_guard hold(guard); }
        rung.notify_one();
    }
    void ring_all(std::atomic<std::uint32_t>&) {
        { const std::lock_guard hold(guard); }
        rung.notify_all();
    }

  private:
    std::mutex guard;
    std::condition_variable rung;
};

// Where libstdc++ has no futex, as on Windows, that of GCC 12 compares before it locks: a wake-up in between is lost, and the
// thread sleeps for ever.
#if defined(__GLIBCXX__) && !defined(_GLIBCXX_HAVE_PLATFORM_WAIT)
using Bell = LockedBell;
#else
using Bell = SystemBell;
#endif

} // namespace lockstone::base
