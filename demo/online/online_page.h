#pragma once
/// The page of one machine of a match over UDP. The next page plays the recording.

#include "options.h"
#include "pages/page.h"

namespace lockstone::demo {

/// Opens the page for --host, --join or --watch. `stage` must outlive the page. Errors: no such scene, a bad
/// invitation, a port in use, or a program that was built without lockstone::net.
Result<std::unique_ptr<Page>> open_online_page(const Options& options, Stage& stage);

} // namespace lockstone::demo
