/* How the machines of a match agree that another one comes in, and from which tick on: src/session/join/admission.cpp, made small.
 *
 * Machines 0, 1 and 2 play; J wants to come in. A machine that hears J says yes and a tick; one that does not hear it says no. The latest
 * tick holds; who sees that all tell the same is ready; where all are ready it is settled. Every link holds one packet, which a newer
 * one replaces: so any may be lost, and any may come late. Machine 2 is honest, or it lies: then it tells each of the others anything, in
 * any order. Of one ticket a no or a ready that was heard is never taken back; the model has one ticket.
 *
 * What must hold, whatever happens first:
 *   agreement   honest machines that have settled have the same tick
 *   no parting  once an honest machine has settled tick t, all other honest ones have or still hold before t: while a word of their own
 *               stands open, machines confirm no tick from its own on
 *   progress    if all are honest, in the end all have settled or all have said no
 *
 * FAULT chooses a mutant, 0 none; each must violate one of these:
 *   1  it is settled where all tell the same tick, ready or not
 *   2  who is ready says no when another one does
 *   3  the tick of who is ready still rises
 *   4  who has said yes says no when it hears J no more
 *   5  the tick does not rise to the latest
 */

#ifndef FAULT
#define FAULT 0
#endif
#ifndef SPREAD
#define SPREAD 1 /* ticks that the words may differ by, 1 or 2 */
#endif

#define MACHINES 3
#define FIRST 1              /* the earliest tick that may be told */
#define LAST (FIRST + SPREAD)
#define NONE 0
#define YES 1
#define READY 2
#define NO 3

typedef Word { byte stand; byte tick };
typedef Link { bool waits; Word told; Word known };
typedef Machine {
    Word own;
    bool settled
};

Machine machine[MACHINES];
Link link[9]; /* from i to k: [3 i + k] */
bool lies;    /* machine 2 does */

#define FROM(i, k) link[3 * (i) + (k)]
#define ONE(i) (((i) + 1) % MACHINES)
#define TWO(i) (((i) + 2) % MACHINES)
#define SAYS(i, k, what) (FROM(k, i).known.stand == (what))
#define TELLS_IT(i, k) ((SAYS(i, k, YES) || SAYS(i, k, READY)) && FROM(k, i).known.tick == machine[i].own.tick)
#define ALL_TELL_IT(i) (TELLS_IT(i, ONE(i)) && TELLS_IT(i, TWO(i)))
#define ALL_READY(i) (ALL_TELL_IT(i) && (FAULT == 1 || (SAYS(i, ONE(i), READY) && SAYS(i, TWO(i), READY))))
#define OPEN(i) (machine[i].own.stand == YES || (machine[i].own.stand == READY && !machine[i].settled))
#define ANY_NO(i) (SAYS(i, ONE(i), NO) || SAYS(i, TWO(i), NO))
#define LATER(i, k) ((SAYS(i, k, YES) || SAYS(i, k, READY)) && FROM(k, i).known.tick > machine[i].own.tick)
#define MAY_RISE(i) (FAULT != 5 && (machine[i].own.stand == YES || (FAULT == 3 && OPEN(i))))
#define NEW(i, k) (FROM(i, k).known.stand != machine[i].own.stand || FROM(i, k).known.tick != machine[i].own.tick)
#define SAME(i, k) (FROM(i, k).waits && FROM(i, k).told.stand == machine[i].own.stand && FROM(i, k).told.tick == machine[i].own.tick)

inline send(sender, receiver) {
    FROM(sender, receiver).waits = true;
    FROM(sender, receiver).told.stand = machine[sender].own.stand;
    FROM(sender, receiver).told.tick = machine[sender].own.tick
}
/* A no or a ready that was heard stands. */
inline hear(sender, receiver, what, when) {
    if
    :: FROM(sender, receiver).known.stand == READY || FROM(sender, receiver).known.stand == NO -> skip
    :: else -> FROM(sender, receiver).known.stand = what; FROM(sender, receiver).known.tick = when
    fi
}

#define HONEST(i) ((i) != 2 || !lies)
#define AGREE(i, k) (!machine[i].settled || !machine[k].settled || machine[i].own.tick == machine[k].own.tick)
/* k may run the tick that i has settled, and has not settled it. */
#define PARTED(i, k) (HONEST(i) && HONEST(k) && machine[i].settled && !machine[k].settled && \
                      (!OPEN(k) || machine[k].own.tick > machine[i].own.tick))

inline check() {
    assert(AGREE(0, 1) && AGREE(1, 2) && AGREE(0, 2));
    assert(!PARTED(0, 1) && !PARTED(1, 0) && !PARTED(0, 2) && !PARTED(2, 0) && !PARTED(1, 2) && !PARTED(2, 1))
}

proctype Plays(byte i) {
end:
    do
    :: atomic { machine[i].own.stand == NONE -> machine[i].own.stand = YES; machine[i].own.tick = FIRST }
    :: atomic { machine[i].own.stand == NONE -> machine[i].own.stand = YES; machine[i].own.tick = LAST }
    :: atomic { SPREAD > 1 && machine[i].own.stand == NONE -> machine[i].own.stand = YES; machine[i].own.tick = FIRST + 1 }
    :: atomic { machine[i].own.stand == NONE -> machine[i].own.stand = NO }
    :: atomic { (machine[i].own.stand == YES || (FAULT == 2 && OPEN(i))) && ANY_NO(i) -> machine[i].own.stand = NO; check() }
    :: atomic { FAULT == 4 && machine[i].own.stand == YES -> machine[i].own.stand = NO }
    :: atomic { MAY_RISE(i) && LATER(i, ONE(i)) -> machine[i].own.tick = FROM(ONE(i), i).known.tick; check() }
    :: atomic { MAY_RISE(i) && LATER(i, TWO(i)) -> machine[i].own.tick = FROM(TWO(i), i).known.tick; check() }
    :: atomic { machine[i].own.stand == YES && ALL_TELL_IT(i) -> machine[i].own.stand = READY }
    :: atomic { OPEN(i) && (FAULT == 1 || machine[i].own.stand == READY) && ALL_READY(i) ->
                machine[i].own.stand = READY; machine[i].settled = true; check() }
    :: atomic { NEW(i, ONE(i)) && !SAME(i, ONE(i)) -> send(i, ONE(i)) }
    :: atomic { NEW(i, TWO(i)) && !SAME(i, TWO(i)) -> send(i, TWO(i)) }
    :: atomic { FROM(ONE(i), i).waits -> FROM(ONE(i), i).waits = false; hear(ONE(i), i, FROM(ONE(i), i).told.stand, FROM(ONE(i), i).told.tick) }
    :: atomic { FROM(TWO(i), i).waits -> FROM(TWO(i), i).waits = false; hear(TWO(i), i, FROM(TWO(i), i).told.stand, FROM(TWO(i), i).told.tick) }
    od
}

/* Tells the two others anything, until it has told a ready or a no. */
#define HEARS(to) (FROM(2, to).known.stand == NONE || FROM(2, to).known.stand == YES)
inline tell(to) {
    if
    :: FROM(2, to).known.stand = YES; FROM(2, to).known.tick = FIRST
    :: FROM(2, to).known.stand = YES; FROM(2, to).known.tick = LAST
    :: SPREAD > 1 -> FROM(2, to).known.stand = YES; FROM(2, to).known.tick = FIRST + 1
    :: FROM(2, to).known.stand = READY; FROM(2, to).known.tick = FIRST
    :: SPREAD > 1 -> FROM(2, to).known.stand = READY; FROM(2, to).known.tick = FIRST + 1
    :: FROM(2, to).known.stand = READY; FROM(2, to).known.tick = LAST
    :: FROM(2, to).known.stand = NO; FROM(2, to).known.tick = 0
    fi
}
proctype Lies() {
end:
    do
    :: atomic { HEARS(0) -> tell(0) }
    :: atomic { HEARS(1) -> tell(1) }
    od
}

#define DONE(i) (machine[i].settled || machine[i].own.stand == NO)
#define ALIKE(i, k) (machine[i].settled == machine[k].settled)

init {
    atomic {
        if
        :: lies = true; run Plays(0); run Plays(1); run Lies()
        :: lies = false; run Plays(0); run Plays(1); run Plays(2)
        fi
    }
    timeout; /* nothing is left to do: every step of the honest brings something on */
    assert(lies || (DONE(0) && DONE(1) && DONE(2) && ALIKE(0, 1) && ALIKE(1, 2)))
}
