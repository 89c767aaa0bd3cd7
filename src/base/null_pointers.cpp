// Refuses a build by g++ without -fno-delete-null-pointer-checks.
//
// g++ 12 counts the addresses of some loops from zero. It takes the writes of such a loop for writes through a null
// pointer, and removes calls of functions that write nothing else. A library built with -Os alone then gives other
// hashes. The loops are ordinary ones, so the sources cannot avoid this; the flag does.
#if defined(__GNUC__) && !defined(__clang__)

namespace lockstone::base {
namespace {

extern const char elsewhere; ///< has no definition, as no code reads it
template <bool> struct Constant;

/// True if the compiler assumes that the address of an object of another file is not null.
template <const char& object>
concept HasAddress = requires {
    sizeof(Constant<(&object != nullptr)>*);
};

} // namespace

static_assert(
    !HasAddress<elsewhere>,
    "g++ needs -fno-delete-null-pointer-checks, as CMakeLists.txt gives it: without, it leaves out calls");

} // namespace lockstone::base

#endif
