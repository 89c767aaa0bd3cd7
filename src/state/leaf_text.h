// The value of one field as text, computed from its bytes and its LeafInfo with integers only.
#pragma once

#include "lockstone/row.h"

#include <span>
#include <string>

namespace lockstone {

/// raw / 2^fraction_bits: exact, or rounded to twelve decimals if it has more. "-1.25", "0.333333333256".
std::string decimal_text(std::int64_t raw, int fraction_bits);

/// The decimal value of a leaf of a row: "-1.25".
std::string leaf_text(std::span<const std::byte> row, const LeafInfo& leaf);

/// The decimal value and the bits: "-1.25 (raw 0xfff60000)".
std::string leaf_text_with_raw(std::span<const std::byte> row, const LeafInfo& leaf);

} // namespace lockstone
