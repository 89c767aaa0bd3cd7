#include "font.h"

#include <stb_truetype.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace lockstone::demo {
namespace {

/// ASCII, the upper half of Latin-1 and a few symbols, if the font has them.
std::vector<char32_t> code_points() {
    std::vector<char32_t> codes;
    for (char32_t code = 0x20; code < 0x7F; ++code) codes.push_back(code);
    for (char32_t code = 0xA0; code <= 0xFF; ++code) codes.push_back(code);
    for (const char32_t code : U"–—•…←↑→↓−≈≠≤≥■□▲▶▼◀○●█▒✓✗")
        if (code != 0) codes.push_back(code);
    return codes;
}

/// The number of bytes of a UTF-8 sequence with this first byte; 0 if it is no valid first byte.
std::size_t sequence_length(unsigned lead) {
    if (lead < 0x80) return 1;
    if (lead >> 5 == 0x06) return 2;
    if (lead >> 4 == 0x0E) return 3;
    if (lead >> 3 == 0x1E) return 4;
    return 0;
}

/// The coverage values of one cell.
using Cell = std::vector<std::uint8_t>;

/// Draws the glyph of `code` into `cell`; false if the font lacks it. `baseline` counts from the top [px].
bool draw_glyph(const stbtt_fontinfo& info, char32_t code, float scale, int baseline, const glm::ivec2& size,
                Cell& cell) {
    const int index = stbtt_FindGlyphIndex(&info, static_cast<int>(code));
    if (index == 0) return false;
    int x = 0, y = 0, x_end = 0, y_end = 0;
    stbtt_GetGlyphBitmapBox(&info, index, scale, scale, &x, &y, &x_end, &y_end);
    // Parts outside of the cell are cut; box-drawing characters exceed it by design.
    const int left = std::clamp(x, 0, size.x), top = std::clamp(baseline + y, 0, size.y);
    const int width = std::min(x_end - x, size.x - left), height = std::min(y_end - y, size.y - top);
    if (width > 0 && height > 0)
        stbtt_MakeGlyphBitmap(&info, cell.data() + top * size.x + left, width, height, size.x, scale, scale,
                              index);
    return true;
}

} // namespace

struct Font::Atlas {
    int width = 0;
    int height = 0;
    glm::ivec2 cell{0};
    std::vector<std::uint8_t> coverage;
    std::map<char32_t, GlyphBox> glyphs;
    glm::vec2 white{0};
};

Font::Font(std::span<const std::uint8_t> ttf, int line_height) : Font(draw(ttf, line_height)) {}

Font::Font(const Atlas& atlas)
    : cell_(atlas.cell), white_(atlas.white), glyphs_(atlas.glyphs),
      texture_(Texture::from_coverage(atlas.width, atlas.height, atlas.coverage)) {}

Font::Atlas Font::draw(std::span<const std::uint8_t> ttf, int line_height) {
    stbtt_fontinfo info{};
    if (stbtt_InitFont(&info, ttf.data(), 0) == 0)
        throw std::runtime_error("the font file is no TrueType font");
    int advance = 0, ascent = 0, descent = 0;
    stbtt_GetCodepointHMetrics(&info, 'M', &advance, nullptr);
    stbtt_GetFontVMetrics(&info, &ascent, &descent, nullptr);
    line_height = std::max(line_height, 6);

    Atlas atlas;
    const float wanted = stbtt_ScaleForPixelHeight(&info, static_cast<float>(line_height));
    atlas.cell = {std::max(3, static_cast<int>(std::lround(wanted * static_cast<float>(advance)))),
                  line_height};
    // The advance is a whole number of pixels, so that all letters of a line have the same subpixel position.
    const float scale = static_cast<float>(atlas.cell.x) / static_cast<float>(advance);
    const auto baseline = static_cast<int>(std::lround(0.5f * static_cast<float>(line_height) +
                                                       0.5f * scale * static_cast<float>(ascent + descent)));

    constexpr int columns = 16;
    constexpr int gap = 1; // keeps the filter from reading the neighbouring cell
    const std::vector<char32_t> codes = code_points();
    const glm::ivec2 pitch = atlas.cell + gap;
    // One cell more than there are codes: the white one.
    const int rows = (static_cast<int>(codes.size()) + columns) / columns;
    atlas.width = columns * pitch.x;
    atlas.height = rows * pitch.y;
    atlas.coverage.assign(static_cast<std::size_t>(atlas.width) * static_cast<std::size_t>(atlas.height), 0);
    const glm::vec2 size(atlas.width, atlas.height);

    Cell cell(static_cast<std::size_t>(atlas.cell.x) * static_cast<std::size_t>(atlas.cell.y));
    for (int slot = 0; slot <= static_cast<int>(codes.size()); ++slot) {
        const glm::ivec2 corner = glm::ivec2(slot % columns, slot / columns) * pitch;
        const bool last = slot == static_cast<int>(codes.size());
        std::fill(cell.begin(), cell.end(), last ? std::uint8_t{255} : std::uint8_t{0});
        if (last) {
            atlas.white = (glm::vec2(corner) + 0.5f * glm::vec2(atlas.cell)) / size;
        } else {
            const char32_t code = codes[static_cast<std::size_t>(slot)];
            if (!draw_glyph(info, code, scale, baseline, atlas.cell, cell)) continue;
            atlas.glyphs[code] = {glm::vec2(corner) / size, glm::vec2(corner + atlas.cell) / size};
        }
        for (int row = 0; row < atlas.cell.y; ++row)
            std::copy_n(cell.begin() + row * atlas.cell.x, atlas.cell.x,
                        atlas.coverage.begin() + (corner.y + row) * atlas.width + corner.x);
    }
    if (!atlas.glyphs.contains(U'?')) throw std::runtime_error("the font lacks a question mark");
    return atlas;
}

const GlyphBox& Font::glyph(char32_t code) const {
    const auto found = glyphs_.find(code);
    return found == glyphs_.end() ? glyphs_.at(U'?') : found->second;
}

char32_t take_code_point(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned lead = byte(0);
    const std::size_t length = sequence_length(lead);
    char32_t code = length == 1 ? lead : lead & (0x7Fu >> length);
    bool good = length != 0 && length <= text.size();
    for (std::size_t i = 1; good && i < length; ++i) {
        good = byte(i) >> 6 == 0x2;
        code = code << 6 | (byte(i) & 0x3Fu);
    }
    text.remove_prefix(good ? length : 1);
    return good ? code : U'\uFFFD';
}

} // namespace lockstone::demo
