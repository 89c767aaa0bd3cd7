#pragma once
/// A match over UDP as one of its machines sees it. Followed by the page that plays the recording back.

#include "options.h"
#include "pages/page.h"

namespace lockstone::demo {

/// Of --host and --join. `stage` outlives the page. Errors: no such scene, an invitation that is none, a port that is taken;
/// or that this program was built without lockstone::net.
Result<std::unique_ptr<Page>> open_online_page(const Options& options, Stage& stage);

} // namespace lockstone::demo
