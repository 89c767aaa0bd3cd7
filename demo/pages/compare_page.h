#pragma once
/// A scene in two engines, one drawn over the other: ours solid, the thesis' as outlines; energy and distance as curves.

#include "options.h"
#include "page.h"

#include <memory>

namespace lockstone::demo {

/// `stage` outlives the page. The error says that this program has been built without the thesis' engine, that there is
/// no such scene, or what in it that engine lacks.
Result<std::unique_ptr<Page>> open_comparison(const Options& options, Stage& stage);
/// The same error, before a window opens for nothing.
Status check_comparison(const Options& options);

} // namespace lockstone::demo
