#include "cli/match/key_file.h"

#include "cli/text.h"

#include <filesystem>

#include <sys/stat.h>

namespace lockstone::cli {

Result<NetKey> key_in(const std::string& file) {
    constexpr std::size_t longest = 4096; // a key and its line end are shorter
    Result<std::string> text = read_file(file, longest);
    if (!text) return text.error();
    while (!text->empty() && text->back() == '\n') text->pop_back();
    Result<NetKey> key = parse_key(*text);
    if (!key) return Error{file + ": " + key.error().message};
    return key;
}

Result<NetKey> key_of(const std::string& file, bool is_new) {
    if (is_new) {
        if (std::filesystem::exists(file))
            return Error{file + ": exists already; leave out --new-key, or give another file"};
        ::umask(077); // only the owner may read the secret
        if (Status s = write_file(file, to_string(random_key()) + "\n"); !s) return s.error();
    }
    return key_in(file);
}

} // namespace lockstone::cli
