#include "cook/read/ply_strips.h"

#include "cook/import.h"

#include <bit>
#include <cstring>
#include <map>
#include <sstream>

namespace lockstone::cook {
namespace {

enum class PlyNumber { i8, u8, i16, u16, i32, u32, f32, f64 };
const std::map<std::string, PlyNumber> numbers{
    {"char", PlyNumber::i8},    {"int8", PlyNumber::i8},     {"uchar", PlyNumber::u8},
    {"uint8", PlyNumber::u8},   {"short", PlyNumber::i16},   {"int16", PlyNumber::i16},
    {"ushort", PlyNumber::u16}, {"uint16", PlyNumber::u16},  {"int", PlyNumber::i32},
    {"int32", PlyNumber::i32},  {"uint", PlyNumber::u32},    {"uint32", PlyNumber::u32},
    {"float", PlyNumber::f32},  {"float32", PlyNumber::f32}, {"double", PlyNumber::f64},
    {"float64", PlyNumber::f64}};

struct PlyProperty {
    std::string name;
    bool is_list = false;
    PlyNumber count = PlyNumber::u8, number = PlyNumber::f32;
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    std::string format;
    std::vector<PlyElement> elements;

    bool has(const char* name) const {
        return std::any_of(elements.begin(), elements.end(),
                           [&](const PlyElement& e) { return e.name == name; });
    }
};

/// Adds a line of the header; false if this reader does not understand it.
bool add_line(PlyHeader& header, const std::string& line) {
    std::istringstream words(line);
    std::string word, count, number;
    words >> word;
    if (word == "format") return static_cast<bool>(words >> header.format);
    if (word == "element") {
        PlyElement& element = header.elements.emplace_back();
        return static_cast<bool>(words >> element.name >> element.count);
    }
    if (word != "property") return true; // comment, obj_info
    if (header.elements.empty() || !(words >> number)) return false;
    PlyProperty property;
    if (number == "list") {
        property.is_list = true;
        if (!(words >> count >> number) || !numbers.contains(count)) return false;
        property.count = numbers.at(count);
    }
    if (!numbers.contains(number) || !(words >> property.name)) return false;
    property.number = numbers.at(number);
    header.elements.back().properties.push_back(property);
    return true;
}

std::optional<PlyHeader> read_ply_header(std::istream& in) {
    constexpr int lines_max = 1000;
    PlyHeader header;
    std::string line;
    if (!std::getline(in, line) || !line.starts_with("ply")) return std::nullopt;
    for (int i = 0; i < lines_max && std::getline(in, line); ++i) {
        if (line.ends_with('\r')) line.pop_back();
        if (line == "end_header") return header;
        if (!add_line(header, line)) return std::nullopt;
    }
    return std::nullopt;
}

/// Reads the numbers of the file's body, as text or bytes.
class PlyBody {
  public:
    PlyBody(std::istream& from, const std::string& format)
        : in(from), is_text(format == "ascii"),
          is_swapped((format == "binary_big_endian") != (std::endian::native == std::endian::big)) {}

    /// The next number; 0 after the end of the file.
    double number(PlyNumber kind) {
        if (is_text) {
            double value = 0;
            in >> value;
            return value;
        }
        switch (kind) {
        case PlyNumber::i8:
            return bytes<std::int8_t>();
        case PlyNumber::u8:
            return bytes<std::uint8_t>();
        case PlyNumber::i16:
            return bytes<std::int16_t>();
        case PlyNumber::u16:
            return bytes<std::uint16_t>();
        case PlyNumber::i32:
            return bytes<std::int32_t>();
        case PlyNumber::u32:
            return bytes<std::uint32_t>();
        case PlyNumber::f32:
            return static_cast<double>(bytes<float>());
        case PlyNumber::f64:
            break;
        }
        return bytes<double>();
    }
    bool good() const { return static_cast<bool>(in); }

  private:
    template <class T> T bytes() {
        std::array<char, sizeof(T)> raw{};
        in.read(raw.data(), sizeof(T));
        if (is_swapped) std::reverse(raw.begin(), raw.end());
        return std::bit_cast<T>(raw);
    }
    std::istream& in;
    bool is_text, is_swapped;
};

/// Appends the triangles of strips. Every second triangle of a strip has the opposite winding.
bool add_strips(const std::vector<double>& indices, std::vector<Indices>& triangles) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (indices[i] < 0) {
            begin = i + 1;
            continue;
        }
        if (indices[i] > 4e9) return false;
        if (i < begin + 2) continue;
        const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(indices[k]); };
        if ((i - begin) % 2 == 0)
            triangles.push_back({at(i - 2), at(i - 1), at(i)});
        else
            triangles.push_back({at(i - 1), at(i - 2), at(i)});
    }
    return true;
}

Result<Soup> read_ply_body(std::istream& in, const PlyHeader& header) {
    const Error cut{"the PLY file ends within its triangle strips"};
    Soup soup;
    PlyBody body(in, header.format);
    for (const PlyElement& element : header.elements)
        for (std::uint64_t i = 0; i < element.count; ++i) {
            Point point;
            std::vector<double> list;
            for (const PlyProperty& property : element.properties) {
                const double count = property.is_list ? body.number(property.count) : 1;
                for (double k = 0; k < count && body.good(); ++k) {
                    const double value = body.number(property.number);
                    if (property.is_list) list.push_back(value);
                    if (property.name == "x") point.x = value;
                    if (property.name == "y") point.y = value;
                    if (property.name == "z") point.z = value;
                }
                if (!body.good()) return cut;
            }
            if (element.name == "vertex") soup.vertices.push_back(point);
            if (element.name == "tristrips" && !add_strips(list, soup.triangles)) return cut;
            if (soup.vertices.size() > import_vertices_max || soup.triangles.size() > import_triangles_max)
                return Error{"it has more triangles than a mesh may have"};
            if (element.properties.empty()) break;
        }
    if (soup.triangles.empty()) return Error{"its triangle strips hold no triangles"};
    return soup;
}

} // namespace

std::optional<Result<Soup>> read_ply_strips(std::istream& in) {
    const std::optional<PlyHeader> header = read_ply_header(in);
    if (!header || !header->has("tristrips")) return std::nullopt;
    return read_ply_body(in, *header);
}

} // namespace lockstone::cook
