// Real numbers of 200 bits as values, by MPFR: the reference for exact integer formulas.
#pragma once

#include "lockstone/math/fixed.h"

#define MPFR_USE_INTMAX_T
#include <mpfr.h>

#include <cstdint>

namespace oracle {

class Big {
    mpfr_t value;

  public:
    Big(double d = 0) { mpfr_init2(value, 200), mpfr_set_d(value, d, MPFR_RNDN); }
    Big(std::int64_t raw, int fraction_bits) {
        mpfr_init2(value, 200);
        mpfr_set_sj(value, raw, MPFR_RNDN);
        mpfr_div_2si(value, value, fraction_bits, MPFR_RNDN);
    }
    template <lockstone::FixedPoint T> explicit Big(T x) : Big(std::int64_t{x.raw}, T::fraction_bits) {}
    Big(const Big& b) { mpfr_init2(value, 200), mpfr_set(value, b.value, MPFR_RNDN); }
    Big& operator=(const Big& b) { return mpfr_set(value, b.value, MPFR_RNDN), *this; }
    ~Big() { mpfr_clear(value); }

    static Big pi() {
        Big b;
        return mpfr_const_pi(b.value, MPFR_RNDN), b;
    }
    double to_double() const { return mpfr_get_d(value, MPFR_RNDN); }

    friend Big operator+(const Big& a, const Big& b) { return apply(mpfr_add, a, b); }
    friend Big operator-(const Big& a, const Big& b) { return apply(mpfr_sub, a, b); }
    friend Big operator*(const Big& a, const Big& b) { return apply(mpfr_mul, a, b); }
    friend Big operator/(const Big& a, const Big& b) { return apply(mpfr_div, a, b); }
    friend Big operator-(const Big& a) { return Big(0) - a; }
    friend bool operator<(const Big& a, const Big& b) { return mpfr_less_p(a.value, b.value) != 0; }
    friend Big sqrt(const Big& a) { return apply(mpfr_sqrt, a); }
    friend Big sin(const Big& a) { return apply(mpfr_sin, a); }
    friend Big cos(const Big& a) { return apply(mpfr_cos, a); }
    friend Big atan(const Big& a) { return apply(mpfr_atan, a); }
    friend Big abs(const Big& a) { return apply(mpfr_abs, a); }

  private:
    static Big apply(int (*f)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t), const Big& a, const Big& b) {
        Big out;
        return f(out.value, a.value, b.value, MPFR_RNDN), out;
    }
    static Big apply(int (*f)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t), const Big& a) {
        Big out;
        return f(out.value, a.value, MPFR_RNDN), out;
    }
};

} // namespace oracle
