// The command `lockstone cook`.
#include "cook/cook.h"
#include "cli/commands.h"
#include "cli/text.h"
#include "cook/import.h"
#include "cook/memory_limit.h"
#include "json/json.h"

#include <algorithm>
#include <cstdio>
#include <new>
#include <stdexcept>

namespace lockstone::cli {
namespace {

struct Args {
    std::string model, asset, as = "hull";
    cook::CookOptions options;
    cook::ImportLimits limits;
    std::uint64_t memory_mb = 1024;
    std::uint32_t corners_max = 0; ///< 0: not given
    bool json = false;
};

constexpr std::size_t longest_name = 4000; // characters of a name that are printed

const std::map<std::string, cook::Wanted> kinds{{"hull", cook::Wanted::hull},
                                                {"convex", cook::Wanted::convex},
                                                {"mesh", cook::Wanted::mesh},
                                                {"height-field", cook::Wanted::height_field}};

void describe(CLI::App& command, Args& args) {
    add_text(command, "MESH", args.model, "model file: glTF, OBJ, FBX, STL or PLY").required();
    add_text(command, "-o", args.asset, "asset file to write").required().type_name("ASSET");
    std::vector<std::string> names;
    for (const auto& [name, kind] : kinds) names.push_back(name);
    add_text(command, "--as", args.as,
             "kind of asset: hull, convex (a compound of hulls), mesh or height-field")
        .one_of(names)
        .show_default();
    add_real(command, "--scale", args.options.scale, "metres per unit of the model, default 1", 1e-9, 1e9);
    add_real(command, "--deviation", args.options.deviation,
             "largest allowed deviation from the model [m]; default: 1 % of the model's largest extent; hull "
             "and convex aim for 1 % and may take 20 %",
             0, 1e4);
    add_number(command, "--parts", args.options.parts_max, "convex: largest number of hulls", 1,
               compound_parts_max);
    add_number(command, "--vertices", args.corners_max,
               "hull, convex: largest number of vertices of a hull, 4 to 255; default: 64; --as hull takes "
               "more where the deviation needs them",
               4, hull_vertices_max);
    add_flag(command, "--two-sided", args.options.two_sided,
             "mesh: triangles collide on both sides, so the mesh has no inside");
    add_flag(command, "--flip", args.options.flip, "reverse the triangles, for a surface that is inside out");
    add_real(command, "--flat", args.options.flat,
             "mesh, height-field: contacts ignore edges with a smaller angle [degrees], 0 to 90", 0, 90);
    add_real(command, "--spacing", args.options.spacing,
             "height-field: distance between samples [m]; default: as large as the deviation allows", 1e-4,
             1e3);
    add_number(command, "--seconds", args.limits.seconds, "time limit for reading the model [s], 1 to 86400",
               1, 86400);
    add_number(command, "--memory", args.memory_mb, "memory limit of the whole command [MB], 64 or more", 64,
               1u << 24);
    add_flag(command, "--z-up", args.options.z_up, "the model's z axis points up");
    add_flag(command, "--json", args.json, "print the report as JSON");
}

json::Value report_of(const Args& args, const cook::Cooked& made) {
    const cook::Point origin = made.origin;
    json::Value json{{"model", args.model},
                     {"asset", args.asset},
                     {"kind", name_of(made.kind)},
                     {"id", hash_text(made.id.value)},
                     {"bytes", made.bytes()},
                     {"source_vertices", made.source_vertices},
                     {"source_triangles", made.source_triangles},
                     {"vertices", made.vertices},
                     {"triangles", made.triangles},
                     {"parts", made.parts},
                     {"deviation_m", made.deviation},
                     {"deviation_aimed_m", made.deviation_aimed},
                     {"deviation_allowed_m", made.deviation_max},
                     {"notes", made.notes}};
    if (made.kind == ShapeKind::hull) json["gap_m"] = made.gap;
    if (made.parts_dropped > 0) json["parts_dropped"] = made.parts_dropped;
    if (made.kind == ShapeKind::height_field) {
        json["spacing_m"] = made.spacing;
        json["origin_m"] = {origin.x, origin.y, origin.z};
    }
    return json;
}

void print(const Args& args, const cook::Cooked& made) {
    if (args.json) {
        std::printf("%s\n", report_of(args, made).dump(2).c_str());
        return;
    }
    std::printf("%s: %s %s, %zu vertices, %zu triangles", shown(args.asset, longest_name).c_str(),
                name_of(made.kind), hash_text(made.id.value).c_str(), made.vertices, made.triangles);
    if (made.parts > 0) std::printf(", %zu %s", made.parts, made.parts == 1 ? "part" : "parts");
    std::printf(", %zu bytes\ndeviation %.3g m, %.3g m are aimed for and %.3g m allowed\n", made.bytes(),
                made.deviation, made.deviation_aimed, made.deviation_max);
    // [m], of coordinates: the hull of a convex model extends no further beyond the model.
    constexpr double rounding = 1e-6;
    if (made.kind == ShapeKind::hull && made.gap > std::max(made.deviation_max, rounding))
        std::printf("the model is concave: the hull reaches %.3g m beyond it (--as convex follows it)\n",
                    made.gap);
    if (made.parts_dropped > 0) std::printf("%zu parts were too thin and are left out\n", made.parts_dropped);
    if (made.kind == ShapeKind::height_field)
        std::printf("samples every %.6g m; the first lies at %.6g %.6g %.6g m in the model\n", made.spacing,
                    made.origin.x, made.origin.y, made.origin.z);
    for (const std::string& note : made.notes) std::printf("note: %s\n", note.c_str());
}

/// The flags that bring an asset nearer to its model.
std::string flags_of(const Args& args) {
    if (args.as == "hull") return "--deviation allows more, --vertices keeps more corners";
    if (args.as == "convex")
        return "--deviation allows more, --parts and --vertices follow the model closer, --as mesh keeps all "
               "triangles";
    return args.as == "mesh" ? "--deviation allows more"
                             : "--deviation allows more, a smaller --spacing follows the model closer";
}

/// Writes, reads what was written, and compares.
Status write_and_read(const std::string& path, const cook::Cooked& made) {
    const AssetBytes bytes = encode_assets(made.assets);
    const char* text = reinterpret_cast<const char*>(bytes.data());
    if (Status s = write_file(path, std::string(text, bytes.size())); !s) return s;
    AssetLibrary library;
    const Result<AssetId> id = load_assets(path, library);
    if (!id) return id.error();
    return *id == made.id ? Status{}
                          : Error{path + ": the written file differs when it is read back; write it again"};
}

/// Reads the model and makes the asset within a limit of memory.
Result<cook::Cooked> cook_within(const Args& args) {
    cook::CookOptions options = args.options;
    options.as = kinds.at(args.as);
    if (args.corners_max != 0) options.corners_max = args.corners_max;
    const cook::MemoryLimit limit(args.memory_mb << 20);
    cook::ImportLimits limits = args.limits;
    limits.memory = limit.address_space();
    const auto refused = [&] {
        return Error{args.model + ": needs more than " + std::to_string(args.memory_mb) +
                     " MB of memory (--memory allows more)"};
    };
    try {
        const Result<cook::Soup> model = cook::import_model(args.model, limits);
        if (!model) return model.error();
        Result<cook::Cooked> made = cook::cook(*model, options);
        if (!made) return Error{args.model + ": as " + args.as + ": " + made.error().message};
        return made;
    } catch (const std::bad_alloc&) { return refused(); } catch (const std::length_error&) {
        return refused();
    }
}

Result<Exit> run(const Args& args) {
    if (Status s = check_outputs({args.asset}, {args.model}); !s) return s.error();
    const Result<cook::Cooked> made = cook_within(args);
    if (!made) return made.error();
    if (!made->good()) {
        print(args, *made);
        std::fprintf(stderr, "lockstone: %s: deviates by %g m, %g m are allowed; nothing was written (%s)\n",
                     shown(args.model, longest_name).c_str(), made->deviation, made->deviation_max,
                     flags_of(args).c_str());
        return Exit::check_failed;
    }
    if (Status s = write_and_read(args.asset, *made); !s) return s.error();
    print(args, *made);
    return Exit::good;
}

} // namespace

void add_cook(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "cook",
                      "Make an asset from a model, check it, and measure its deviation from the model.",
                      describe, run);
}

} // namespace lockstone::cli
