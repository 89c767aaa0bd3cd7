#include "host.h"

#include <cfenv>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace host {

namespace {

bool poisons = false;
unsigned char poison_byte = 0;

/// splitmix64: a generator without a library, so that it is equal everywhere.
std::uint64_t next(std::uint64_t& state) {
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// The header before the block: its size, and before that the pointer from malloc.
struct Header {
    void* base;
    std::size_t size;
};

void* allocate(std::size_t size, std::size_t alignment) {
    const std::size_t room = alignment + sizeof(Header);
    if (size > SIZE_MAX - room) std::abort();
    void* const base = std::malloc(size + room);
    if (base == nullptr) std::abort();
    const auto start = reinterpret_cast<std::uintptr_t>(base) + sizeof(Header);
    const auto place = (start + alignment - 1) / alignment * alignment;
    const Header header{base, size};
    std::memcpy(reinterpret_cast<void*>(place - sizeof(Header)), &header, sizeof header);
    void* const block = reinterpret_cast<void*>(place);
    if (poisons) std::memset(block, poison_byte, size);
    return block;
}

void release(void* block) {
    if (block == nullptr) return;
    Header header;
    std::memcpy(&header, static_cast<char*>(block) - sizeof header, sizeof header);
    if (poisons) std::memset(block, static_cast<unsigned char>(~poison_byte), header.size);
    std::free(header.base);
}

#if defined(FE_UPWARD) && defined(FE_DOWNWARD) && defined(FE_TOWARDZERO)
constexpr int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST};
#else
constexpr int modes[] = {FE_TONEAREST};
#endif

/// The control bits for flushing denormals of this machine's unit.
std::uint64_t control_word() {
#if defined(__SSE2__)
    return _mm_getcsr();
#elif defined(__aarch64__)
    std::uint64_t word;
    asm volatile("mrs %0, fpcr" : "=r"(word));
    return word;
#elif defined(__arm__) && defined(__VFP_FP__)
    std::uint32_t word;
    asm volatile("vmrs %0, fpscr" : "=r"(word));
    return word;
#else
    return 0;
#endif
}
void set_control_word([[maybe_unused]] std::uint64_t word) {
#if defined(__SSE2__)
    _mm_setcsr(static_cast<unsigned>(word));
#elif defined(__aarch64__)
    asm volatile("msr fpcr, %0" : : "r"(word));
#elif defined(__arm__) && defined(__VFP_FP__)
    asm volatile("vmsr fpscr, %0" : : "r"(static_cast<std::uint32_t>(word)));
#endif
}
#if defined(__SSE2__)
constexpr std::uint64_t flush_bits = 0x8040; // flush to zero, denormals are zero
#else
constexpr std::uint64_t flush_bits = std::uint64_t{1} << 24; // FZ of both FPCR and FPSCR
#endif

#if defined(__i386__) || defined(__x86_64__)
constexpr std::uint16_t precisions[] = {0x000, 0x200, 0x300}; // 24, 53 and 64 bits of significand
std::uint16_t x87_control() {
    std::uint16_t word;
    asm volatile("fnstcw %0" : "=m"(word));
    return word;
}
void set_x87_control(std::uint16_t word) { asm volatile("fldcw %0" : : "m"(word)); }
#endif

/// One thread that runs the items in random order and reports a random worker number each time.
class Shuffled final : public lockstone::Tasks {
  public:
    explicit Shuffled(std::uint64_t seed) : state(seed) {}
    std::uint32_t worker_count() const override { return 5; }
    void run(std::uint32_t items, Item item, void* context) override {
        order.resize(items);
        for (std::uint32_t i = 0; i < items; ++i) order[i] = i;
        for (std::uint32_t i = items; i > 1; --i) std::swap(order[i - 1], order[next(state) % i]);
        for (const std::uint32_t index : order)
            item(context, index, static_cast<std::uint32_t>(next(state) % 5));
    }

  private:
    std::uint64_t state;
    std::vector<std::uint32_t> order;
};

} // namespace

void poison(unsigned char byte) { poisons = true, poison_byte = byte; }

void move_heap(std::uint64_t seed) {
    std::uint64_t state = seed;
    std::vector<std::unique_ptr<char[]>> blocks;
    for (int i = 0; i < 40; ++i) blocks.push_back(std::make_unique<char[]>(next(state) % 60000));
    for (auto& block : blocks)
        if (next(state) % 3 != 0)
            block.reset();
        else if (next(state) % 8 == 0)
            static_cast<void>(block.release()); // remains allocated to the end of the program
}

FloatingPoint::FloatingPoint(bool on, std::uint64_t tick) : active(on) {
    if (!active) return;
    rounding = std::fegetround();
    control = control_word();
    std::fesetround(modes[tick % (sizeof modes / sizeof *modes)]);
    if (control != 0 || flush_bits != 0x8040)
        if (tick / 4 % 2 == 0) set_control_word(control_word() | flush_bits);
#if defined(__i386__) || defined(__x86_64__)
    precision = x87_control();
    set_x87_control(static_cast<std::uint16_t>((x87_control() & ~0x300u) | precisions[tick % 3]));
#endif
}

FloatingPoint::~FloatingPoint() {
    if (!active) return;
    set_control_word(control);
#if defined(__i386__) || defined(__x86_64__)
    set_x87_control(precision);
#endif
    std::fesetround(rounding);
}

std::unique_ptr<lockstone::Tasks> make_tasks(std::uint32_t workers, std::uint64_t shuffle) {
    if (shuffle != 0) return std::make_unique<Shuffled>(shuffle);
    if (workers == 0) return nullptr;
#if defined(LOCKSTONE_NO_THREADS)
    std::fprintf(stderr, "matrix_hash: this build has no threads\n");
    std::exit(2);
#else
    return lockstone::make_worker_pool(workers);
#endif
}

} // namespace host

#if !defined(LOCKSTONE_OWN_ALLOCATOR) // sanitizers have their own
void* operator new(std::size_t size) { return host::allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size) { return host::allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t a) {
    return host::allocate(size, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t size, std::align_val_t a) {
    return host::allocate(size, static_cast<std::size_t>(a));
}
// WebAssembly's library does not derive these two from the others, and the functions below free their memory.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return host::allocate(size, alignof(std::max_align_t));
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return host::allocate(size, alignof(std::max_align_t));
}
void operator delete(void* p) noexcept { host::release(p); }
void operator delete[](void* p) noexcept { host::release(p); }
void operator delete(void* p, std::size_t) noexcept { host::release(p); }
void operator delete[](void* p, std::size_t) noexcept { host::release(p); }
void operator delete(void* p, std::align_val_t) noexcept { host::release(p); }
void operator delete[](void* p, std::align_val_t) noexcept { host::release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { host::release(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { host::release(p); }
#endif

#if defined(__wasm__) // this libc++abi has no exceptions; only programming errors throw
extern "C" void* __cxa_allocate_exception(std::size_t) { std::abort(); }
extern "C" void __cxa_throw(void*, void*, void (*)(void*)) { std::abort(); }
#endif
