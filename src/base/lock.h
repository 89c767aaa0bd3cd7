// A lock; empty in builds without threads (LOCKSTONE_NO_THREADS).
#pragma once

#if !defined(LOCKSTONE_NO_THREADS)
#include <mutex>
#endif

namespace lockstone::base {

#if defined(LOCKSTONE_NO_THREADS)
struct Lock {
    void lock() {}
    void unlock() {}
};
#else
using Lock = std::mutex;
#endif

/// Holds the lock during its lifetime.
class Holds {
  public:
    explicit Holds(Lock& lock) : held(lock) { held.lock(); }
    ~Holds() { held.unlock(); }
    Holds(const Holds&) = delete;
    Holds& operator=(const Holds&) = delete;

  private:
    Lock& held;
};

} // namespace lockstone::base
