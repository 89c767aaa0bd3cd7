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

/// Decodes an image file held in memory; `name` is for the error text.
Image decode_image(std::span<const std::uint8_t> bytes, const std::string& name);

/// Writes a PNG file. Throws std::runtime_error naming the file if it cannot.
void write_png(const Image& image, const std::filesystem::path& path);

/// The whole file. Throws std::runtime_error naming the file and the reason.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);

} // namespace lockstone::demo
