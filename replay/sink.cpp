#include "replay/sink.h"

#include "base/text.h"

#include <cerrno>
#include <system_error>

#if defined(__unix__) && !defined(__EMSCRIPTEN__)
#define LOCKSTONE_HAS_FILE_LOCKS 1
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#else
#define LOCKSTONE_HAS_FILE_LOCKS 0
#endif

namespace lockstone::replay {
namespace {

/// The system's text for the error of the last call.
std::string system_reason() {
    return errno == 0 ? std::string("no reason given") : std::generic_category().message(errno);
}

} // namespace

#if LOCKSTONE_HAS_FILE_LOCKS

Result<FileSink> FileSink::create(const std::string& path) {
    errno = 0;
    // Does not truncate yet: another recorder may be writing the file.
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    std::FILE* file = descriptor < 0 ? nullptr : ::fdopen(descriptor, "wb");
    if (file == nullptr) {
        const Error error{base::join(path, ": cannot create the file: ", system_reason())};
        if (descriptor >= 0) ::close(descriptor);
        return error;
    }
    FileSink sink(path, file);
    struct stat about {};
    if (::fstat(descriptor, &about) == 0 && !S_ISREG(about.st_mode)) return sink; // a pipe, a terminal
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return Error{base::join(path, ": cannot create the file: another recorder is writing it")};
    if (::ftruncate(descriptor, 0) != 0)
        return Error{base::join(path, ": cannot empty the file: ", system_reason())};
    return sink;
}

std::string FileSink::find_change() const {
    struct stat ours {
    }, there{};
    if (::fstat(::fileno(file.get()), &ours) != 0 || !S_ISREG(ours.st_mode)) return {};
    if (::stat(path.c_str(), &there) != 0) return "the file was removed or moved while it was written";
    if (there.st_dev != ours.st_dev || there.st_ino != ours.st_ino)
        return "the file was replaced by another while it was written";
    if (static_cast<std::uint64_t>(ours.st_size) != size)
        return base::join("the file has ", ours.st_size, " bytes where ", size,
                          " were written: another program changed it");
    return {};
}

bool is_being_written(const std::string& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ::close(descriptor);
    return locked;
}

#else

Result<FileSink> FileSink::create(const std::string& path) {
    errno = 0;
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return Error{base::join(path, ": cannot create the file: ", system_reason())};
    return FileSink(path, file);
}

std::string FileSink::find_change() const { return {}; }
bool is_being_written(const std::string&) { return false; }

#endif

Status FileSink::append(std::span<const std::byte> bytes) {
    if (!file) return Error{base::join(path, ": cannot write, the file is closed")};
    if (const std::string change = find_change(); !change.empty())
        return Error{base::join(path, ": cannot write ", bytes.size(), " bytes: ", change)};
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() &&
        std::fflush(file.get()) == 0) {
        size += bytes.size();
        return {};
    }
    const Error error{base::join(path, ": cannot write ", bytes.size(), " bytes: ", system_reason())};
#if LOCKSTONE_HAS_FILE_LOCKS
    // fclose() would write the rest of the buffer, so the file is truncated after it; a failure here leaves a cut
    // file, which can be read as well.
    const int descriptor = ::dup(::fileno(file.get()));
    file.reset();
    if (descriptor >= 0) {
        if (::ftruncate(descriptor, static_cast<off_t>(size)) != 0) errno = 0;
        ::close(descriptor);
    }
#endif
    return error;
}

Status FileSink::close() {
    if (!file) return {};
    errno = 0;
    if (std::fclose(file.release()) == 0) return {};
    return Error{base::join(path, ": cannot close the file: ", system_reason())};
}

Status StreamSink::append(std::span<const std::byte> bytes) {
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (out.flush()) return {};
    return Error{base::join(name, ": cannot write ", bytes.size(), " bytes: the stream failed")};
}

} // namespace lockstone::replay
