// Open and disputed edges of a surface, the solids that it encloses, and a coarse copy of it.
#pragma once

#include "cook/soup.h"

namespace lockstone::cook {

/// Counts over a welded soup.
struct Soundness {
    std::size_t edges_open = 0;     ///< edges of one triangle
    std::size_t edges_disputed = 0; ///< edges at which two triangles face opposite ways
    double volume = 0; ///< [m^3], negative when the triangles face inwards; of a closed surface alone

    bool closed() const { return edges_open == 0; }
    bool oriented() const { return edges_disputed == 0; }
    /// Each triangle faces away from a volume.
    bool sound() const { return closed() && oriented() && volume > 0; }
};
Soundness soundness_of(const Soup& soup);

/// The soups whose triangles share no vertex with each other, by their first triangles.
std::vector<Soup> components_of(const Soup& soup);

/// At most `triangles_max` triangles near those of the soup: vertices within one cell of a grid become the first of them. The same soup where it
/// has no more.
Soup coarsened(const Soup& soup, std::size_t triangles_max);

} // namespace lockstone::cook
