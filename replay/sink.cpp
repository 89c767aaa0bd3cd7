#include "replay/sink.h"

#include "base/text.h"

#include <cerrno>
#include <system_error>

namespace lockstone::replay {
namespace {

/// The system's words for the error of the last call.
std::string system_reason() {
    return errno == 0 ? std::string("no reason given") : std::generic_category().message(errno);
}

} // namespace

Result<FileSink> FileSink::create(const std::string& path) {
    errno = 0;
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return Error{base::join(path, ": cannot create the file: ", system_reason())};
    return FileSink(path, file);
}

Status FileSink::append(std::span<const std::byte> bytes) {
    if (!file) return Error{base::join(path, ": cannot write, the file is closed")};
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() &&
        std::fflush(file.get()) == 0)
        return {};
    return Error{base::join(path, ": cannot write ", bytes.size(), " bytes: ", system_reason())};
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
