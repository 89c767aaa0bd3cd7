// A progress bar on a terminal. In a pipe it prints nothing.
#pragma once

#include <cstdint>
#include <string>

namespace lockstone::cli {

class Progress {
  public:
    Progress(std::string what, std::uint64_t total);
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress(); ///< erases the line

    void at(std::uint64_t done);
    /// Erases the bar before a line is printed to stdout; the next at() draws it again.
    void wipe();

  private:
    std::string label;
    std::uint64_t total;
    std::uint64_t shown = ~std::uint64_t{0}; ///< hundredths that the bar shows
    bool on;
};

} // namespace lockstone::cli
