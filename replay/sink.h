// Destinations of a recording: a file, a stream or memory. A sink appends bytes and never rewrites them.
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
    /// Writes all bytes, out of this process's buffers (so a crash of the process cannot lose them), or returns an
    /// error with the name of the sink and the reason.
    virtual Status append(std::span<const std::byte> bytes) = 0;
    /// Called after the last append. Returns errors that the system reports late.
    virtual Status close() { return {}; }
};

/// A file. create() replaces an existing file, but not one that another sink is writing, in this process or another:
/// a sink holds a lock on its file. If the file was removed, replaced or changed in the meantime, the next append
/// returns an error. On systems without such locks (other than Unix), neither is detected.
class FileSink final : public Sink {
  public:
    static Result<FileSink> create(const std::string& path);
    /// On an error the file is cut back to its size before the call, so that it ends with a whole chunk.
    Status append(std::span<const std::byte> bytes) override;
    Status close() override;

  private:
    struct Close {
        void operator()(std::FILE* f) const { std::fclose(f); }
    };
    FileSink(std::string where, std::FILE* open) : path(std::move(where)), file(open) {}
    /// Checks that the file at the path is the created one, unchanged since the last append. Returns an
    /// empty text if it is, else the change.
    std::string find_change() const;
    std::string path;
    std::unique_ptr<std::FILE, Close> file;
    std::uint64_t size = 0; ///< bytes written so far
};

/// Returns true if a FileSink of any process has this file open now. False if the system cannot detect that.
bool is_being_written(const std::string& path);

/// A stream of the caller, which must outlive the sink; flushed after every append.
class StreamSink final : public Sink {
  public:
    StreamSink(std::ostream& to, std::string stream_name) : out(to), name(std::move(stream_name)) {}
    Status append(std::span<const std::byte> bytes) override;

  private:
    std::ostream& out;
    std::string name;
};

/// A sink in memory; `bytes` is the file.
class MemorySink final : public Sink {
  public:
    std::vector<std::byte> bytes;
    Status append(std::span<const std::byte> more) override {
        bytes.insert(bytes.end(), more.begin(), more.end());
        return {};
    }
};

} // namespace lockstone::replay
