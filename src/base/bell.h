// Puts a thread to sleep until a number changes, after the thread has polled the number for a while.
//
//   number.store(7), bell.ring_all(number);          // first the number, then the bell
//   bell.wait(number, seen);                         // returns at once if the number is not `seen` any more
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <type_traits>

namespace lockstone::base {

/// The wait of the standard library.
class SystemBell {
  public:
    void wait(const std::atomic<std::uint32_t>& number, std::uint32_t seen) {
        number.wait(seen, std::memory_order_acquire);
    }
    void ring_one(std::atomic<std::uint32_t>& number) { number.notify_one(); }
    void ring_all(std::atomic<std::uint32_t>& number) { number.notify_all(); }
};

/// A condition variable with its own lock. ring_one() and ring_all() take the lock after the number has changed. So a
/// thread that compared the old number before is already waiting, and is woken.
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

// Without a futex, as on Windows, libstdc++ of GCC 12 compares the number before it locks: a wake-up between the two
// is lost, and the thread sleeps for ever.
#if defined(__GLIBCXX__) && !defined(_GLIBCXX_HAVE_PLATFORM_WAIT)
using Bell = LockedBell;
#else
using Bell = SystemBell;
#endif

} // namespace lockstone::base
