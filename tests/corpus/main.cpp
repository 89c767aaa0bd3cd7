// corpus [--planted FAULT] MODEL...: prints one line of the table for each model, then its findings. Exit status 1 if
// there is a finding.
#include "corpus/corpus.h"

#include <cstdio>
#include <cstring>
#include <exception>

int main(int argc, char** argv) {
    using namespace lockstone::corpus;
    Planted planted = Planted::none;
    int first = 1;
    if (argc > 2 && std::strcmp(argv[1], "--planted") == 0) {
        for (const auto& [name, fault] : planted_faults())
            if (name == argv[2]) planted = fault;
        if (planted == Planted::none) {
            std::fprintf(stderr, "corpus: there is no fault %s\n", argv[2]);
            return 2;
        }
        first = 3;
    }
    std::size_t findings = 0;
    for (int i = first; i < argc; ++i) {
        try {
            const Row row = row_of(argv[i], planted);
            std::string text = "ROW\t" + row.text() + "\n";
            for (const std::string& finding : row.findings)
                text += "FINDING\t" + row.model + "\t" + finding + "\n";
            // one write, because several processes run in parallel
            std::fwrite(text.data(), 1, text.size(), stdout);
            std::fflush(stdout);
            findings += row.findings.size();
        } catch (const std::exception& error) {
            std::printf("FINDING\t%s\tends with: %s\n", argv[i], error.what());
            ++findings;
        }
    }
    return findings == 0 ? 0 : 1;
}
