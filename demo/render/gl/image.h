#pragma once
/// Pixels in main memory, and PNG files.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace lockstone::demo {

/// RGBA, 8 bits per channel, sRGB, rows from the top.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels{}; ///< 4 * width * height bytes
};

/// Reads a PNG, JPEG, BMP or TGA file. Throws std::runtime_error naming the file and the reason.
Image load_image(const std::filesystem::path& path);

/// Decodes an image file in memory; `name` is for error messages.
Image decode_image(std::span<const std::uint8_t> bytes, const std::string& name);

/// Writes a PNG file. On failure throws std::runtime_error naming the file.
void write_png(const Image& image, const std::filesystem::path& path);

/// Reads a whole file. Throws std::runtime_error naming the file and the reason.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);

} // namespace lockstone::demo
