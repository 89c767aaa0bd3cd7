// Checks a surface for open and disputed edges, separates the solids that it encloses, and makes a coarse copy.
#pragma once

#include "cook/soup.h"

namespace lockstone::cook {

/// Properties of a welded soup.
struct Soundness {
    std::size_t edges_open = 0;     ///< edges with one triangle
    std::size_t edges_disputed = 0; ///< edges at which two triangles have opposite orientations
    double volume = 0; ///< [m^3], negative if the triangles face inwards; valid only for a closed surface

    bool closed() const { return edges_open == 0; }
    bool oriented() const { return edges_disputed == 0; }
    /// True if each triangle faces away from the enclosed volume.
    bool sound() const { return closed() && oriented() && volume > 0; }
};
Soundness soundness_of(const Soup& soup);

/// The connected components: soups that share no vertex, in the order of their first triangles.
std::vector<Soup> components_of(const Soup& soup);

/// At most `triangles_max` triangles that approximate the soup: vertices in one cell of a grid are merged into the
/// first of them. Returns the soup itself if it has no more triangles than that.
Soup coarsened(const Soup& soup, std::size_t triangles_max);

} // namespace lockstone::cook
