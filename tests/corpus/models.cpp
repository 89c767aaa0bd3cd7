#include "cook/import.h"
#include "cook/soundness.h"
#include "corpus/corpus.h"

#include <cstdio>
#include <ctime>

namespace lockstone::corpus {
namespace {

using cook::Cooked;
using cook::CookOptions;
using cook::Soup;
using cook::Wanted;

constexpr double seconds_max = 10; ///< processor time, for parts
constexpr std::size_t parts_max = 32;

std::string in_text(const char* format, double a, double b = 0) {
    char text[200];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}

const char* name_of(Wanted as) {
    return as == Wanted::mesh ? "mesh" : as == Wanted::hull ? "hull" : "convex";
}

bool holds(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

/// Returns false for messages of libraries about their own state.
bool is_helpful(const std::string& sentence) {
    for (const char* words : {"qhull gave up", "No meshes remaining", "bad_alloc", "disagrees with itself"})
        if (holds(sentence, words)) return false;
    return true;
}

/// The file's own unit if its size in that unit is usual; else a scale to 2 m.
double scale_of(const Soup& model) {
    const cook::Box box = cook::bounds_of(model.vertices);
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis)
        reach = std::max({reach, std::abs(box.lower[axis]), std::abs(box.upper[axis])});
    const bool is_usual = box.largest() >= 0.2 && box.largest() <= 10 && reach <= 100;
    return is_usual || box.largest() <= 0 ? 1 : 2 / box.largest();
}

struct Cooking {
    Row& row;
    const Soup& model;
    const CookOptions& options;
    bool is_sound;
    Planted planted;
};

Result<Cooked> cook_one(const Cooking& in, Wanted as, Tried& tried) {
    CookOptions options = in.options;
    options.as = as;
    const std::clock_t begun = std::clock();
    Result<Cooked> made =
        in.planted == Planted::refused ? Error{"it is refused"} : cook::cook(in.model, options);
    tried.seconds = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
    if (made && in.planted == Planted::far) made->deviation = 30 * made->deviation_aimed;
    if (made && in.planted == Planted::slow) tried.seconds = 20, made->parts = 40;
    return made;
}

/// Checks that the assets' bytes load and give the cooked assets.
std::string load_fault(const Cooked& made) {
    AssetLibrary library;
    const Result<AssetId> id = library.add(encode_assets(made.assets));
    if (!id) return "the file does not load: " + id.error().message;
    return *id == made.id ? "" : "the file loads as another asset";
}

/// Cooks the model as one kind and checks the rules for results of sound models.
Result<Cooked> try_kind(const Cooking& in, Wanted as, Tried& tried) {
    const auto add = [&](const std::string& what) {
        in.row.findings.push_back(std::string(name_of(as)) + ": " + what);
    };
    Result<Cooked> made = cook_one(in, as, tried);
    tried.made = made.ok();
    if (!made) {
        tried.sentence = made.error().message;
        const bool is_thin = holds(tried.sentence, "um thick") && holds(tried.sentence, "--scale");
        if (in.is_sound && !is_thin) add("a sound model is refused: " + tried.sentence);
        const bool is_of_file = holds(tried.sentence, "it has no triangle with an area"); // no flag adds one
        if (!is_helpful(tried.sentence) || (!holds(tried.sentence, "--") && !is_of_file))
            add("the refusal names no flag: " + tried.sentence);
        return made;
    }
    tried.good = made->good();
    tried.parts = made->parts;
    tried.share = made->deviation / (made->deviation_aimed / cook::deviation_share_aimed);
    if (in.is_sound && !tried.good) add(in_text("a sound model deviates by %.3g of its size", tried.share));
    if (as == Wanted::convex && tried.seconds > seconds_max)
        add(in_text("took %.3g s of a processor", tried.seconds));
    if (as == Wanted::convex && tried.parts > parts_max)
        add(in_text("has %.0f parts", static_cast<double>(tried.parts)));
    if (const std::string fault = load_fault(*made); !fault.empty()) add(fault);
    return made;
}

/// A model that is too large or too small in its own unit must be made, or refused with the flag that helps.
void try_own_unit(Row& row, const Soup& model) {
    const Result<Cooked> made = cook::cook(model, {});
    if (!made && !holds(made.error().message, "--scale") && !holds(made.error().message, "--as mesh"))
        row.findings.push_back("in its own unit: the refusal does not name --scale: " + made.error().message);
}

/// The flags that a mesh's notes name.
CookOptions with_noted_flags(const Cooking& in, const Cooked& mesh, const cook::Soundness& soundness) {
    CookOptions options = in.options;
    std::string notes;
    if (in.planted != Planted::silent)
        for (const std::string& note : mesh.notes) notes += note;
    options.flip = holds(notes, "--flip");
    // An open surface, on which balls fall from above and from below, needs both sides.
    options.two_sided = holds(notes, "--two-sided") || !soundness.closed();
    if (soundness.closed() && soundness.oriented() && soundness.volume < 0 && !options.flip)
        in.row.findings.push_back("mesh: the surface is inside out, and no note says so");
    return options;
}

std::string name_of(const cook::Soundness& s) {
    if (s.sound()) return "sound";
    if (!s.closed()) return "open";
    return s.oriented() ? "inside out" : "disputed";
}

std::string text_of(const Tried& tried) {
    if (!tried.made) return "refused: " + tried.sentence;
    std::string text = in_text(tried.good ? "%.2g %%" : "deviates %.2g %%", 100 * tried.share);
    if (tried.parts > 1)
        text += in_text(", %.0f parts, %.1f s", static_cast<double>(tried.parts), tried.seconds);
    return text;
}

} // namespace

const std::vector<std::pair<std::string, Planted>>& planted_faults() {
    static const std::vector<std::pair<std::string, Planted>> faults{
        {"refused", Planted::refused},   {"far", Planted::far},     {"slow", Planted::slow},
        {"silent", Planted::silent},     {"holes", Planted::holes}, {"lifted", Planted::lifted},
        {"restless", Planted::restless}, {"sunk", Planted::sunk}};
    return faults;
}

std::string Row::text() const {
    std::string out = model + "\t" + sound + "\t" + in_text("%.3g", scale) + "\t" + text_of(mesh) + "\t" +
                      text_of(hull) + "\t" + text_of(convex);
    out +=
        "\t" +
        (balls == 0 ? "-" : in_text("%.0f of %.0f", static_cast<double>(passed), static_cast<double>(balls)));
    out += "\t" + (balls == 0 ? "-" : in_text("%.1f", balls_asleep_at));
    out += "\t" + (hull.made ? in_text("%.2f", 1000 * deepest) : "-") + "\t" +
           (hull.made ? in_text("%.1f", hull_asleep_at) : "-");
    return out;
}

Row row_of(const std::string& path, Planted planted) {
    Row row;
    row.model = path;
    const Result<Soup> model = cook::import_model(path, {.seconds = 30});
    if (!model) {
        row.sound = "unread";
        row.mesh.sentence = row.hull.sentence = row.convex.sentence =
            model.error().message.substr(path.size() + 2);
        if (!is_helpful(row.mesh.sentence))
            row.findings.push_back("the refusal does not help: " + row.mesh.sentence);
        return row;
    }
    CookOptions options;
    options.scale = row.scale = scale_of(*model);
    Soup soup = *model;
    for (cook::Point& p : soup.vertices) p = p * options.scale;
    const cook::Soundness soundness = cook::soundness_of(cook::compacted(cook::welded(soup)));
    row.sound = name_of(soundness);
    if (row.scale != 1) try_own_unit(row, *model);
    const Cooking in{row, *model, options, soundness.sound(), planted};
    if (const Result<Cooked> mesh = try_kind(in, Wanted::mesh, row.mesh))
        drop_balls(row, *model, with_noted_flags(in, *mesh, soundness), planted);
    if (const Result<Cooked> hull = try_kind(in, Wanted::hull, row.hull)) drop_hull(row, *hull, planted);
    (void)try_kind(in, Wanted::convex, row.convex);
    return row;
}

} // namespace lockstone::corpus
