#include "attack/attack.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <malloc.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

// ---- memory ----------------------------------------------------------------------------------------------------

namespace {

std::atomic<std::uint64_t> bytes_now = 0, bytes_peak = 0;

void* counted(void* p) {
    if (p == nullptr) throw std::bad_alloc();
    const std::uint64_t now = bytes_now += malloc_usable_size(p);
    std::uint64_t peak = bytes_peak;
    while (now > peak && !bytes_peak.compare_exchange_weak(peak, now)) {}
    return p;
}

void give_back(void* p) {
    if (p != nullptr) bytes_now -= malloc_usable_size(p);
    std::free(p);
}

} // namespace

void* operator new(std::size_t size) { return counted(std::malloc(size == 0 ? 1 : size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    const auto a = static_cast<std::size_t>(alignment);
    return counted(std::aligned_alloc(a, (size + a - 1) / a * a));
}
void operator delete(void* p) noexcept { give_back(p); }
void operator delete(void* p, std::size_t) noexcept { give_back(p); }
void operator delete(void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }

namespace attack {

std::uint64_t memory_now() { return bytes_now; }
std::uint64_t memory_peak() { return bytes_peak; }
void forget_peak() { bytes_peak = bytes_now.load(); }

// ---- tries -----------------------------------------------------------------------------------------------------

Options read_options(const std::string& kind, int argc, char** argv) {
    Options out;
    out.kind = kind;
    bool good = argc >= 2;
    if (good) out.tries = std::strtoull(argv[1], nullptr, 10);
    for (int i = 2; i + 1 < argc; i += 2) {
        if (std::string_view(argv[i]) == "--seed")
            out.seed = std::strtoull(argv[i + 1], nullptr, 10);
        else if (std::string_view(argv[i]) == "--only")
            out.only = std::strtoull(argv[i + 1], nullptr, 10);
        else if (std::string_view(argv[i]) == "--planted")
            out.planted = argv[i + 1];
        else
            good = false;
    }
    if (good && out.tries != 0 && argc % 2 == 0) return out;
    std::fprintf(stderr, "attack_%s TRIES [--seed S] [--planted FAULT] [--only TRY]\n", kind.c_str());
    std::exit(2);
}

std::uint64_t& Figures::operator[](std::string_view name) {
    for (Sum& sum : sums) {
        if (sum.name[0] == '\0') name.copy(sum.name.data(), sum.name.size() - 1);
        if (name == sum.name.data()) return sum.value;
    }
    std::fprintf(stderr, "attack: too many figures\n");
    std::abort();
}

std::string Figures::text() const {
    std::string out;
    for (const Sum& sum : sums)
        if (sum.name[0] != '\0')
            out += (out.empty() ? "" : ", ") + std::string(sum.name.data()) + " " + std::to_string(sum.value);
    return out;
}

namespace {

/// Memory that parent and child share.
struct Shared {
    std::uint64_t next; ///< the child's current try
    std::uint64_t findings;
    Figures figures;
};

[[noreturn]] void child(const Options& options, const Try& one_try, Shared& shared) {
    const unsigned seconds = options.planted == "hang" ? 2 : seconds_max;
    for (; shared.next < options.tries; ++shared.next) {
        alarm(seconds);
        const std::string found = one_try(shared.next, shared.figures);
        alarm(0);
        if (found.empty()) continue;
        ++shared.findings;
        std::printf("%s: seed %llu, try %llu: %s\n", options.kind.c_str(),
                    static_cast<unsigned long long>(options.seed),
                    static_cast<unsigned long long>(shared.next), found.c_str());
        std::fflush(stdout);
    }
    std::_Exit(0);
}

std::string end_of(int status) {
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return "takes too long";
    if (WIFSIGNALED(status)) return std::string("ended by ") + strsignal(WTERMSIG(status));
    return "ended with status " + std::to_string(WEXITSTATUS(status)); // the exit of a sanitizer
}

} // namespace

int run(const Options& options, const Try& one_try) {
    if (options.only < options.tries) {
        Figures figures{};
        const std::string found = one_try(options.only, figures);
        std::printf("%s; %s\n", figures.text().c_str(), found.empty() ? "nothing found" : found.c_str());
        return found.empty() ? 0 : 1;
    }
    void* const memory =
        mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) std::abort();
    Shared& shared = *new (memory) Shared{};
    while (shared.next < options.tries) {
        std::fflush(stdout);
        const pid_t pid = fork();
        if (pid == 0) child(options, one_try, shared);
        int status = 0;
        if (pid < 0 || waitpid(pid, &status, 0) != pid) std::abort();
        if (status == 0) continue;
        ++shared.findings;
        std::printf("%s: seed %llu, try %llu: %s\n", options.kind.c_str(),
                    static_cast<unsigned long long>(options.seed),
                    static_cast<unsigned long long>(shared.next), end_of(status).c_str());
        ++shared.next;
    }
    std::printf("%s: %llu tries, %s; %llu findings\n", options.kind.c_str(),
                static_cast<unsigned long long>(options.tries), shared.figures.text().c_str(),
                static_cast<unsigned long long>(shared.findings));
    return shared.findings == 0 ? 0 : 1;
}

} // namespace attack
