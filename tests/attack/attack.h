// Shared parts of all attacks: counted tries, each in a child process that may crash, hang or use too much memory.
//
//   int main(int argc, char** argv) {
//       const attack::Options options = attack::read_options("files", argc, argv);
//       return attack::run(options, [&](std::uint64_t number, attack::Figures& figures) -> std::string {
//           ...                                        // an error sentence, or an empty string
//       });
//   }
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace attack {

struct Options {
    std::string kind;
    std::uint64_t tries = 0, seed = 1;
    std::string planted;                    ///< empty: none
    std::uint64_t only = ~std::uint64_t{0}; ///< runs one try in this process: for a debugger
};
/// Ends the program with a sentence if the usage is wrong.
Options read_options(const std::string& kind, int argc, char** argv);

/// Sums over all tries, by short names that the program chooses, in memory that children share.
class Figures {
  public:
    std::uint64_t& operator[](std::string_view name); ///< at most 16 names of at most 23 letters
    std::string text() const;                         ///< "read 12, refused 7"

  private:
    struct Sum {
        std::array<char, 24> name;
        std::uint64_t value;
    };
    std::array<Sum, 16> sums;
};

inline constexpr unsigned seconds_max = 20; ///< limit of one try

/// Returns an error sentence about one try, or an empty string.
using Try = std::function<std::string(std::uint64_t number, Figures& figures)>;
/// Returns the exit status of the program. With a planted hang the limit of a try is 2 seconds.
int run(const Options& options, const Try& one_try);

// ---- memory: attack.cpp replaces operator new ----
std::uint64_t memory_now(); ///< bytes allocated and not freed, by all threads
void forget_peak();
std::uint64_t memory_peak(); ///< greatest value of memory_now() since forget_peak

} // namespace attack
