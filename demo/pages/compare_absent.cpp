// Replaces compare_page.cpp in builds without the thesis' engine (tools/reference), which needs FCL.
#include "compare_page.h"

namespace lockstone::demo {

Result<std::unique_ptr<Page>> open_comparison(const Options& options, Stage&) {
    return check_comparison(options).error();
}

Status check_comparison(const Options&) {
    return Error{
        "--compare needs the thesis' engine, tools/reference, and this program was built without it: "
        "install libfcl-dev and configure with -DLOCKSTONE_BUILD_REFERENCE=ON"};
}

} // namespace lockstone::demo
