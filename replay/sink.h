// Where a recording goes: a file, a stream or memory. A sink appends bytes and never rewrites them.
#pragma once

#include "lockstone/result.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace lockstone::replay {

class Sink {
  public:
    virtual ~Sink() = default;
    /// All of the bytes and out of this process's buffers (a crash of the process cannot lose them), or an error that
    /// names the sink and the reason.
    virtual Status append(std::span<const std::byte> bytes) = 0;
    /// After the last append. Errors that the system reports late come here.
    virtual Status close() { return {}; }
};

/// A file. An existing file is replaced, but not one that another sink is writing, in this process or another: while a
/// sink has the file, it holds a lock on it. A file that was removed, replaced or changed meanwhile is an error of the next
/// append. Where the system has no such locks (other than Unix), neither is noticed.
class FileSink final : public Sink {
  public:
    static Result<FileSink> create(const std::string& path);
    /// On an error the file is cut back to what it held before, so that it ends with a whole chunk.
    Status append(std::span<const std::byte> bytes) override;
    Status close() override;

  private:
    struct Close {
        void operator()(std::FILE* f) const { std::fclose(f); }
    };
    FileSink(std::string where, std::FILE* open) : path(std::move(where)), file(open) {}
    /// Why the file under the path is not the one that was created, as it was left; empty when it is.
    std::string find_change() const;
    std::string path;
    std::unique_ptr<std::FILE, Close> file;
    std::uint64_t size = 0; ///< that was written
};

/// Whether a FileSink of any process has this file open now. False where the system cannot tell.
bool is_being_written(const std::string& path);

/// A stream of the caller's, flushed after every append.
class StreamSink final : public Sink {
  public:
    StreamSink(std::ostream& to, std::string stream_name) : out(to), name(std::move(stream_name)) {}
    Status append(std::span<const std::byte> bytes) override;

  private:
    std::ostream& out;
    std::string name;
};

/// Memory; `bytes` is the file.
class MemorySink final : public Sink {
  public:
    std::vector<std::byte> bytes;
    Status append(std::span<const std::byte> more) override {
        bytes.insert(bytes.end(), more.begin(), more.end());
        return {};
    }
};

} // namespace lockstone::replay
