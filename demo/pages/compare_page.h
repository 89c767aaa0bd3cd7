#pragma once
/// Shows a scene in two engines: Lockstone's bodies solid, the thesis' bodies as outlines, energy and distance as
/// curves.

#include "options.h"
#include "page.h"

#include <memory>

namespace lockstone::demo {

/// Opens the page. `stage` must outlive it. Errors: the program was built without the thesis' engine, there is no such
/// scene, or the scene needs something that this engine lacks.
Result<std::unique_ptr<Page>> open_comparison(const Options& options, Stage& stage);
/// Returns that error in advance, before a window opens.
Status check_comparison(const Options& options);

} // namespace lockstone::demo
