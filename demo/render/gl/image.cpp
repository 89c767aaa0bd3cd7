#include "image.h"

#include <stb_image.h>
#include <stb_image_write.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>

namespace lockstone::demo {

std::vector<std::uint8_t> read_file(const std::filesystem::path& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        throw std::runtime_error("cannot read " + path.string() + ": it is a directory");
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot open " + path.string() + ": " + std::strerror(errno));
    std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (file.bad()) throw std::runtime_error("cannot read " + path.string());
    return bytes;
}

Image decode_image(std::span<const std::uint8_t> bytes, const std::string& name) {
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw std::runtime_error("cannot decode image " + name + ": it is larger than 2 GiB");
    Image image;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &image.width, &image.height,
                              &channels, 4),
        stbi_image_free);
    if (!pixels) throw std::runtime_error("cannot decode image " + name + ": " + stbi_failure_reason());
    const std::size_t size =
        4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    image.pixels.assign(pixels.get(), pixels.get() + size);
    return image;
}

Image load_image(const std::filesystem::path& path) { return decode_image(read_file(path), path.string()); }

void write_png(const Image& image, const std::filesystem::path& path) {
    std::vector<std::uint8_t> bytes;
    const auto append = [](void* context, void* data, int size) {
        const auto* begin = static_cast<const std::uint8_t*>(data);
        auto* out = static_cast<std::vector<std::uint8_t>*>(context);
        out->insert(out->end(), begin, begin + size);
    };
    if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.pixels.data(),
                               4 * image.width) == 0)
        throw std::runtime_error("cannot encode " + path.string() + " as PNG");
    // The image is encoded in memory first, so that a full disk causes an error with the reason and not a silently
    // truncated file.
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(errno));
}

} // namespace lockstone::demo
