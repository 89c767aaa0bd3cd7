// Stories that once had other bits in another execution mode. The program `worlds` found and shrank them.
#include "kept.h"

namespace worlds {

namespace {

// A point that a contact lacks appears to close at the limit of speeds. Its lane got an impulse if another lane of the
// pack was active.
Story idle_lane() {
    Story s = kept(1);
    set(s.def.substeps, 1);
    set(s.def.sleeping, 0);
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.y, 36511427122);
        set(c.def.pose.position.z, 33739865080);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 1);
        set(c.def.geometry.radius, 1669332967);
        set(c.def.local.position.x, -274877890560);
        set(c.def.local.position.y, 274877906943);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.angular_velocity.x, 17587891077120);
        set(c.def.angular_velocity.y, 17587891077120);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 3);
        set(c.def.geometry.kind, 3);
        set(c.def.geometry.half_extent.x, 6072914);
        set(c.def.geometry.half_extent.y, 6443740);
        set(c.def.geometry.half_extent.z, 6072914);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 5);
        set(c.def.local.position.y, 274877906944);
    });
    add<CreateBody>(s, 0, [](auto& c) { set(c.def.angular_velocity.x, -17587891077120); });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 7);
        set(c.def.geometry.kind, 3);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.local.position.x, 274877841408);
        set(c.def.local.position.y, -274877906944);
        set(c.def.local.rotation.x, 496214348);
        set(c.def.local.rotation.y, -922609280);
        set(c.def.local.rotation.z, 234508155);
        set(c.def.local.rotation.w, 22155521);
    });
    // Two pairs of distant balls, so that lanes of two widths form different packs.
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t body = static_cast<std::uint32_t>(s.steps.size()) + 1;
        add<CreateBody>(s, 0, [&](auto& c) {
            c.def.pose.position = {Real(-400) - Real(static_cast<std::int32_t>(10 * (i / 2))), Real{},
                                   Real(300) + (i % 2 == 0 ? Real{} : 0.5_r)};
            c.def.gravity_scale = Real{};
        });
        add<CreateShape>(s, 0, [&](auto& c) { name(c.body, body); });
    }
    return s;
}

// Bodies may move by 15 m in a tick. Beyond 8 m the gap of a contact of one point depended on whether its pack had
// contacts of several points.
Story far_motion() {
    Story s = kept(13);
    set(s.def.substeps, 3);
    set(s.def.integrator, 1);
    set(s.def.bounds_shift, 8);
    set(s.def.sleeping, 0);
    set(s.def.restitution_speed_min, 0);
    set(s.def.contact_hertz, 17179869184000);
    set(s.def.contact_damping, 429496729600);
    set(s.def.push_speed_max, 16384000);
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) { name(c.body, 1); });
    add<CreateBody>(s, 0, [](auto& c) { set(c.def.kind, 0); });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 3);
        set(c.def.geometry.kind, 9);
        set(c.def.geometry.radius, 0);
        set(c.def.local.position.z, 128066539145);
        set(c.def.local.rotation.x, 452211133);
        set(c.def.local.rotation.w, 973871961);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 5);
        set(c.def.geometry.kind, 4);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 41943);
    });
    add<CreateField>(s, 12, [](auto& c) {
        set(c.def.kind, 1);
        set(c.def.center.z, 4294967296000000000);
        set(c.def.strength, -429496729600000000);
    });
    return s;
}

// Forty balls in one place, whose passes workers solve as one run, and a character. That run did not move the
// character, because it has no contact.
Story character_in_a_crowd() {
    Story s = kept(3);
    set(s.def.sleeping, 0);
    for (std::uint32_t i = 0; i < 40; ++i) {
        add<CreateBody>(s, 0, [](auto& c) { (void)c; });
        add<CreateShape>(s, 0, [&](auto& c) { name(c.body, 2 * i + 1); });
    }
    add<CreateCharacter>(s, 0, [](auto& c) { (void)c; });
    return s;
}

// A thin capsule that turns, within the wider margin of its points of another shape, but not within its own margin. A
// cached separating axis of the last tick existed in one mode and not in the other.
Story plate_beyond_its_margin() {
    Story s = kept(2);
    set(s.def.sleeping, 0);
    add<CreateBody>(s, 0, [](auto& c) { set(c.def.kind, 0); });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 1);
        set(c.def.geometry.kind, 9);
        set(c.def.geometry.radius, 0);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 3);
        set(c.def.geometry.kind, 4);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 1553186642);
        set(c.def.geometry.half_extent.z, 8388608);
        set(c.def.local.rotation.y, 521394137);
        set(c.def.local.rotation.w, 938653109);
        set(c.def.restitution, 4294967295);
    });
    add<CreateBody>(s, 0, [](auto& c) { set(c.def.angular_velocity.y, -19706384393); });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 5);
        set(c.def.geometry.kind, 2);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 8388608);
        set(c.def.geometry.half_extent.y, 517131933);
        set(c.def.geometry.half_extent.z, 8388608);
        set(c.def.local.position.x, 274877905920);
        set(c.def.local.rotation.x, 28772733);
        set(c.def.local.rotation.y, -887603574);
        set(c.def.local.rotation.z, 478626217);
        set(c.def.local.rotation.w, 367655375);
        set(c.def.surface_velocity.x, 429496729600);
    });
    add<CreateField>(s, 0, [](auto& c) {
        set(c.def.kind, 1);
        set(c.def.center.y, -4294967295999999999);
        set(c.def.strength, 50828575571766279);
    });
    return s;
}

// Impacts drive a velocity to the end of its range. SSE4.1 compared numbers of 64 bits by the sign of their difference,
// which overflowed.
// Long: a line for each value.
Story saturated_velocity() {
    Story s = kept(2);
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -4294963215781069);
        set(c.def.pose.position.y, -4294950116130815);
        set(c.def.pose.position.z, 4294967295999970);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 1);
        set(c.def.geometry.kind, 2);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 2955385);
        set(c.def.geometry.half_extent.y, 4688704);
        set(c.def.geometry.half_extent.z, 2955385);
        set(c.def.restitution, 2559555051);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) { name(c.body, 3); });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 5);
        set(c.def.geometry.radius, 1677721600);
        set(c.def.local.rotation.z, -374250649);
        set(c.def.local.rotation.w, 1006408444);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) { name(c.body, 7); });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -4294959135562138);
        set(c.def.pose.position.y, -4294950116130815);
        set(c.def.pose.position.z, 4294975456437832);
        set(c.def.linear_velocity.z, 935205700612);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 9);
        set(c.def.geometry.kind, 4);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.local.position.z, -274877906944);
        set(c.def.local.rotation.y, 646744766);
        set(c.def.local.rotation.w, 857113010);
        set(c.def.surface_velocity.z, -429496729600);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -4294955055343207);
        set(c.def.pose.position.y, -4294950116130815);
        set(c.def.pose.position.z, 4294975456437832);
        set(c.def.pose.rotation.z, -739309808);
        set(c.def.pose.rotation.w, 778679980);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 11);
        set(c.def.geometry.kind, 4);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1548023210);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.local.position.z, 274877906944);
        set(c.def.local.rotation.y, 204123257);
        set(c.def.local.rotation.z, 937852932);
        set(c.def.local.rotation.w, 481159898);
        set(c.def.density, 42949673);
        set(c.def.restitution, 4294967296);
    });
    add<CreateBody>(s, 0, [](auto& c) { (void)c; });
    add<CreateShape>(s, 0, [](auto& c) { name(c.body, 13); });
    add<CreateJoint>(s, 0, [](auto& c) {
        name(c.def->body_a, 13);
        name(c.def->body_b, 1);
    });
    add<CreateJoint>(s, 0, [](auto& c) {
        name(c.def->body_a, 1);
        name(c.def->body_b, 5);
        set(c.def->frame_a.position.x, 4080218931);
    });
    return s;
}

// The precession of a followed body was longer than 4096 m/s. A kernel clamped it only where another body of its lanes
// had a change.
// Long: a line for each value.
Story long_precession() {
    Story s = kept(1);
    set(s.def.tick_rate, 863);
    set(s.def.substeps, 14);
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.locks, 52);
        set(c.def.pose.position.x, -3865470578699693049);
        set(c.def.pose.position.y, 3115054293356252668);
        set(c.def.pose.position.z, -3865470573397510636);
        set(c.def.mass, 65536004294901);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 1);
        set(c.def.geometry.kind, 4);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 894700453);
        set(c.def.geometry.half_extent.y, 497576698);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.local.position.y, -274877906944);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.kind, 0);
        set(c.def.pose.position.x, -3865470573626628834);
        set(c.def.pose.position.y, 3115054293669682028);
        set(c.def.pose.position.z, -3865470565510327947);
        set(c.def.pose.rotation.x, -935714591);
        set(c.def.pose.rotation.w, 526649512);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 3);
        set(c.def.geometry.kind, 3);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.geometry.scale.x, 67108864);
        set(c.def.geometry.scale.y, 67108864);
        set(c.def.geometry.scale.z, 67108864);
        set(c.def.local.position.y, 274877906943);
        set(c.def.local.position.z, -14369126725);
        set(c.def.local.rotation.z, 524087007);
        set(c.def.local.rotation.w, 937152236);
        set(c.def.friction, 17179869184);
        set(c.def.surface_velocity.y, 429496729600);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -3865470555899732817);
        set(c.def.pose.position.y, 3115054293826396708);
        set(c.def.pose.position.z, -3865470554195436625);
        set(c.def.pose.rotation.x, -739673050);
        set(c.def.pose.rotation.w, 778334943);
        set(c.def.angular_velocity.x, 17587891077119);
        set(c.def.angular_velocity.y, -17587891077120);
        set(c.def.mass, 2917771745125567711);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 5);
        set(c.def.geometry.kind, 2);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 41943);
        set(c.def.geometry.half_extent.y, 1677721600);
        set(c.def.geometry.half_extent.z, 41943);
        set(c.def.local.position.z, 274877906943);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -3865470569094292937);
        set(c.def.pose.position.y, 3115054294139826068);
        set(c.def.pose.position.z, -3865470573424370690);
        set(c.def.pose.rotation.x, 98973197);
        set(c.def.pose.rotation.y, 367483730);
        set(c.def.pose.rotation.z, -344564702);
        set(c.def.pose.rotation.w, 943057095);
        set(c.def.angular_velocity.x, 17587354337280);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 7);
        set(c.def.geometry.radius, 1677721600);
        set(c.def.local.position.x, -257698037760);
        set(c.def.local.position.z, 240518168576);
        set(c.def.local.rotation.y, 718333163);
        set(c.def.local.rotation.w, 798072034);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.locks, 3);
        set(c.def.pose.position.x, -3865470562316916113);
        set(c.def.pose.position.y, 3115054296020402230);
        set(c.def.pose.position.z, -3865470570209915471);
        set(c.def.pose.rotation.x, 803259319);
        set(c.def.pose.rotation.w, 712527874);
        set(c.def.angular_velocity.z, 17586817597440);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 9);
        set(c.def.geometry.kind, 2);
        set(c.def.geometry.radius, 0);
        set(c.def.geometry.half_extent.x, 1677721600);
        set(c.def.geometry.half_extent.y, 41943);
        set(c.def.geometry.half_extent.z, 1677721600);
        set(c.def.local.position.x, -274877906944);
        set(c.def.local.position.y, -274877906880);
        set(c.def.local.position.z, 274877906944);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.locks, 44);
        set(c.def.pose.position.x, -3865470553668982951);
        set(c.def.pose.position.y, 3115054297274119672);
        set(c.def.pose.position.z, -3865470583632832648);
        set(c.def.angular_velocity.y, -11299064685);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 11);
        set(c.def.geometry.kind, 5);
        set(c.def.geometry.scale.x, 1677721600);
        set(c.def.geometry.scale.y, 1677721600);
        set(c.def.geometry.scale.z, 1677720800);
        set(c.def.geometry.asset.value, -9220117545996843044);
        set(c.def.local.position.x, 274877906944);
        set(c.def.local.position.y, -274877906944);
        set(c.def.local.position.z, -274877906912);
        set(c.def.restitution, 2347166629);
        set(c.def.surface_velocity.z, 429496729600);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.kind, 0);
        set(c.def.pose.position.x, -3865470553719711446);
        set(c.def.pose.position.y, 3115054301035271995);
        set(c.def.pose.rotation.x, -574208285);
        set(c.def.pose.rotation.y, -263057492);
        set(c.def.pose.rotation.z, 213652464);
        set(c.def.pose.rotation.w, 841641094);
    });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 13);
        set(c.def.geometry.kind, 9);
        set(c.def.geometry.radius, 0);
        set(c.def.local.rotation.x, 776153375);
        set(c.def.local.rotation.w, 741961888);
    });
    add<CreateBody>(s, 0, [](auto& c) {
        set(c.def.pose.position.x, -3865470559417545780);
        set(c.def.pose.position.y, 3115054301191986676);
        set(c.def.pose.position.z, -3865470578471786265);
        set(c.def.pose.rotation.z, 253494321);
        set(c.def.pose.rotation.w, 1043389732);
    });
    add<CreateShape>(s, 0, [](auto& c) { name(c.body, 15); });
    add<CreateShape>(s, 0, [](auto& c) {
        name(c.body, 15);
        set(c.def.geometry.radius, 1677721600);
        set(c.def.local.position.x, -274877906944);
        set(c.def.local.position.z, 274877906944);
    });
    add<CreateJoint>(s, 0, [](auto& c) {
        name(c.def->body_a, 1);
        name(c.def->body_b, 5);
    });
    return s;
}

} // namespace

std::vector<KeptStory> kept_stories() {
    return {{"a contact that does nothing gets no impulse from its pack", idle_lane()},
            {"the gap of a contact of one point does not depend on its pack", far_motion()},
            {"a character moves where all passes are one run", character_in_a_crowd()},
            {"a plate has a contact by its own margin", plate_beyond_its_margin()},
            {"velocities at the end of their range are compared alike", saturated_velocity()},
            {"a long precession is clamped once", long_precession()}};
}

std::string first_apart(const Story& story) {
    for (const Simd simd : every_simd)
        for (const std::uint32_t workers : {1u, 2u, 5u}) {
            if (!has_simd(simd)) continue;
            Mode mode;
            mode.simd = simd, mode.workers = workers, mode.seed = workers;
            if (workers > 1) mode.runner = Runner::shuffled;
            if (const auto tick = first_tick_apart(story, mode))
                return to_string(mode) + ", tick " + std::to_string(*tick);
        }
    return {};
}

} // namespace worlds
