#include "state/envelope.h"

#include "base/hash.h"

#include <cstring>

namespace lockstone {

namespace {

using base::hex;
using base::join;

constexpr std::uint32_t version = 1;
constexpr std::size_t version_offset = 8, size_offset = 12;

} // namespace

void begin_envelope(const Envelope& envelope, std::vector<std::byte>& out) {
    base::ByteWriter to(out);
    to.bytes(std::as_bytes(std::span(envelope.magic.data(), envelope.magic.size())));
    to.u32(version);
    to.u64(0);
}

void seal_envelope(std::vector<std::byte>& out) {
    base::ByteWriter to(out);
    to.patch_u64(size_offset, out.size() + envelope_checksum_bytes);
    to.u64(base::xxh3(out));
}

void check_envelope(const Envelope& envelope, base::ByteReader& in, std::span<const std::byte> image) {
    const auto found_magic = in.bytes(envelope.magic.size(), "magic");
    if (in.ok() && std::memcmp(found_magic.data(), envelope.magic.data(), envelope.magic.size()) != 0)
        in.fail_at(0, join("not a state ", envelope.noun, ": it should begin with '",
                           envelope.magic.substr(0, envelope.magic.size() - 1), "' and a line feed"));
    const std::uint32_t found_version = in.u32("version");
    if (in.ok() && found_version != version)
        in.fail_at(version_offset,
                   join("format version ", found_version, ", this build reads version ", version));
    const std::uint64_t size = in.u64("size");
    if (in.ok() && size != image.size())
        in.fail_at(size_offset, join("the ", envelope.noun, " should be ", size, " bytes long, but it has ",
                                     image.size()));
    if (in.ok() && in.remaining() < envelope_checksum_bytes)
        in.fail(
            join("the checksum needs ", envelope_checksum_bytes, " bytes, only ", in.remaining(), " remain"));
    if (!in.ok()) return;
    const std::size_t end = image.size() - envelope_checksum_bytes;
    const std::uint64_t stored = base::load_little_endian<std::uint64_t>(image.data() + end);
    const std::uint64_t found = base::xxh3(image.first(end));
    if (stored != found)
        in.fail_at(end, join("damaged: the checksum is ", hex(stored), ", the bytes give ", hex(found)));
}

} // namespace lockstone
