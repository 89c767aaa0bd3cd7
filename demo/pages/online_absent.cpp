// Replaces the folder online in builds without lockstone::net, which needs libsodium.
#include "online/online_page.h"

namespace lockstone::demo {

Result<std::unique_ptr<Page>> open_online_page(const Options&, Stage&) {
    return Error{"a match over UDP needs lockstone::net, and this program was built without it: "
                 "install libsodium-dev and configure with -DLOCKSTONE_BUILD_NET=ON"};
}

} // namespace lockstone::demo
