// What the order of contacts asks of them, as the narrow phase finds it.
#pragma once

#include "solve/contacts/contact.h"
#include "solve/contacts/contact_order.h"

#include <span>
#include <vector>

namespace lockstone::test {

inline std::vector<solve::ContactHead> heads_of(std::span<const solve::Contact> contacts) {
    std::vector<solve::ContactHead> heads;
    for (const solve::Contact& contact : contacts) heads.push_back(solve::head_of(contact));
    return heads;
}

} // namespace lockstone::test
