#include "cook/import.h"

#include "cook/memory_limit.h"
#include "cook/read/read_model.h"

#include <sys/resource.h>
#include <sys/select.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <optional>

namespace lockstone::cook {
namespace {

/// The start of the child's answer. It is followed by `text` bytes of an error sentence, or by the vertices and the
/// triangles.
struct Header {
    std::uint64_t magic, text, vertices, triangles;
};
constexpr std::uint64_t magic = 0x4c4f434b434f4f4b;
constexpr std::uint64_t text_max = 4096;

// ---- the child ------------------------------------------------------------------------------------------------

void limit_child(const ImportLimits& limits) {
    if (limits_memory) {
        const rlimit memory{limits.memory, limits.memory};
        setrlimit(RLIMIT_AS, &memory);
    }
    const rlimit seconds{limits.seconds, limits.seconds}, none{0, 0};
    setrlimit(RLIMIT_CPU, &seconds);
    setrlimit(RLIMIT_CORE, &none);
}

bool send_all(int pipe, const void* data, std::size_t size) {
    const char* at = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t sent = write(pipe, at, size);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        at += sent;
        size -= static_cast<std::size_t>(sent);
    }
    return true;
}

[[noreturn]] void run_child(int pipe, const std::string& path, const ImportLimits& limits) {
    limit_child(limits);
    Header header{magic, 0, 0, 0};
    std::string sentence;
    Soup soup;
    try {
        Result<Soup> read = read_model(path);
        if (read)
            soup = std::move(*read);
        else
            sentence = read.error().message;
    } catch (const std::exception& error) { sentence = error.what(); }
    if (sentence.find("bad_alloc") != std::string::npos) // assimp catches it and returns its name
        sentence = "the importer needs more memory than the limit (--memory allows more)";
    if (soup.triangles.empty() && sentence.empty()) sentence = "the importer gave no reason";
    sentence.resize(std::min<std::size_t>(sentence.size(), text_max));
    header.text = sentence.size();
    if (sentence.empty()) {
        header.vertices = soup.vertices.size();
        header.triangles = soup.triangles.size();
    }
    const bool sent = send_all(pipe, &header, sizeof header) &&
                      send_all(pipe, sentence.data(), sentence.size()) &&
                      send_all(pipe, soup.vertices.data(), header.vertices * sizeof(Point)) &&
                      send_all(pipe, soup.triangles.data(), header.triangles * sizeof(Indices));
    _exit(sent ? 0 : 1);
}

// ---- the parent -----------------------------------------------------------------------------------------------

/// Reads from the child until a deadline.
class Reader {
  public:
    Reader(int from, std::uint32_t seconds)
        : pipe(from), deadline(Clock::now() + std::chrono::seconds(seconds)) {}

    /// Returns false if the child ended too early or the deadline has passed.
    bool take(void* out, std::size_t size) {
        char* at = static_cast<char*>(out);
        while (size > 0) {
            const auto left = std::chrono::duration_cast<std::chrono::microseconds>(deadline - Clock::now());
            timeval wait{left.count() / 1'000'000, left.count() % 1'000'000};
            fd_set readable;
            FD_ZERO(&readable);
            FD_SET(pipe, &readable);
            const int ready = left.count() <= 0 ? 0 : select(pipe + 1, &readable, nullptr, nullptr, &wait);
            if (ready < 0 && errno == EINTR) continue;
            if (ready == 0) return !(late = true);
            const ssize_t got = read(pipe, at, size);
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) return !(ended = true);
            at += got;
            size -= static_cast<std::size_t>(got);
        }
        return true;
    }
    bool late = false;
    bool ended = false; ///< the child closed its end of the pipe

  private:
    using Clock = std::chrono::steady_clock;
    int pipe;
    Clock::time_point deadline;
};

/// The soup or the child's error; empty if the data are neither.
std::optional<Result<Soup>> receive(Reader& reader) {
    Header header{};
    if (!reader.take(&header, sizeof header)) return std::nullopt;
    if (header.magic != magic || header.text > text_max || header.vertices > import_vertices_max ||
        header.triangles > import_triangles_max)
        return std::nullopt;
    if (header.text > 0) {
        std::string sentence(header.text, ' ');
        if (!reader.take(sentence.data(), sentence.size())) return std::nullopt;
        return Error{sentence};
    }
    Soup soup;
    soup.vertices.resize(header.vertices);
    soup.triangles.resize(header.triangles);
    if (!reader.take(soup.vertices.data(), header.vertices * sizeof(Point)) ||
        !reader.take(soup.triangles.data(), header.triangles * sizeof(Indices)))
        return std::nullopt;
    return soup;
}

/// The reason why a child that ended with `status` sent no answer.
std::string reason_of(const Reader& reader, int status, const ImportLimits& limits) {
    if (reader.late) return "the importer took longer than " + std::to_string(limits.seconds) + " s";
    if (!reader.ended || !WIFSIGNALED(status)) return "the importer sent nothing that can be read";
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL)
        return "the importer took too much time or memory (--seconds and --memory allow more)";
    return std::string("the importer crashed (") + strsignal(signal) + ")";
}

} // namespace

Result<Soup> import_model(const std::string& path, const ImportLimits& limits) {
    std::error_code none;
    if (!std::filesystem::exists(path, none)) return Error{path + ": there is no such file"};
    if (!std::filesystem::is_regular_file(path, none))
        return Error{
            path + (std::filesystem::is_directory(path, none) ? ": is a directory" : ": is no regular file")};
    int ends[2];
    if (pipe(ends) != 0) return Error{path + ": cannot make a pipe: " + std::strerror(errno)};
    const pid_t child = fork();
    if (child < 0) return Error{path + ": cannot start the importer: " + std::strerror(errno)};
    if (child == 0) {
        close(ends[0]);
        run_child(ends[1], path, limits);
    }
    close(ends[1]);
    Reader reader(ends[0], limits.seconds);
    const std::optional<Result<Soup>> answer = receive(reader);
    close(ends[0]);
    if (!answer && !reader.ended) kill(child, SIGKILL);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    if (!answer) return Error{path + ": " + reason_of(reader, status, limits)};
    if (!*answer) return Error{path + ": " + answer->error().message};
    if (const std::string why = check(**answer, import_coordinate_max); !why.empty())
        return Error{path + ": " + why};
    return *answer;
}

} // namespace lockstone::cook
