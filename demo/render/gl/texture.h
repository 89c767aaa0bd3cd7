#pragma once
/// A 2D texture on the GPU.

#include "gl.h"
#include "image.h"

#include <filesystem>
#include <span>

namespace lockstone::demo {

/// Immutable 2D texture. Move-only.
class Texture {
  public:
    /// RGBA with mipmaps, repeating, with anisotropic filtering if the driver has it. Shaders read the stored values
    /// without conversion.
    explicit Texture(const Image& image);

    /// One 8-bit channel (red), clamped, linear, no mipmaps: glyph atlases.
    static Texture from_coverage(int width, int height, std::span<const std::uint8_t> coverage);

    /// Reads an image file. Throws std::runtime_error naming the file and the reason.
    static Texture load(const std::filesystem::path& path) { return Texture(load_image(path)); }

    /// Binds to texture unit `unit`.
    void bind(int unit) const;

    int width() const { return width_; }   ///< [px]
    int height() const { return height_; } ///< [px]

  private:
    Texture(int width, int height);

    GlTexture name_;
    int width_ = 0;
    int height_ = 0;
};

} // namespace lockstone::demo
