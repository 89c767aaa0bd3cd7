/* How the machines of a match agree that one of them has left, and from which tick on: src/session/departure.cpp, made small.
 *
 * Machines 0, 1 and 2 play; machine X is the one that leaves. X has made inputs for the ticks 0 .. INPUTS - 1, sends them to whom it
 * likes, and may fall silent at any point. A packet tells its sender's whole word: how many of X's inputs it has, whether X has left for
 * it, its cut. Every link holds one packet, which a newer one replaces: so any may be lost, and any may come late. X may leave for a
 * machine at any time: that most must want so is not asked here, so more can happen than can in a match.
 *
 * What must hold, whatever happens first:
 *   agreement   who has settled the cut has the same one
 *   no loss     no machine has confirmed a tick with X's true input that the cut takes from it
 *   no stop     honest machines never find that they cannot agree
 *   progress    all settle the cut in the end
 *
 * FAULT chooses a mutant, 0 none; each must violate one of these:
 *   1  a tick is confirmed as soon as its input is here
 *   2  inputs of X are taken after it has left
 *   3  who has a cut settles it, whatever the others tell
 *   4  the cut is told before the others say that X has left for them
 *   5  that X has left is told together with the cut, not before
 */

#ifndef FAULT
#define FAULT 0
#endif

#define MACHINES 3
#define INPUTS 1 /* with 2 the search had no end, and no error, after 16 million states and 3.4 GB */
#define NEVER 7

typedef Word {
    byte next;   /* of X's inputs: how many are here */
    bool gone;   /* X has left for it */
    byte cut     /* NEVER: not told yet */
};
typedef Link {
    bool waits;  /* a packet is on its way */
    Word told;   /* what it tells */
    Word known   /* what the receiver knows of the sender */
};
typedef Machine {
    Word own;
    byte confirmed; /* ticks that have run for good on X's true inputs */
    bool settled
};

Machine machine[MACHINES];
Link link[9]; /* from i to k: [3 i + k] */

#define FROM(i, k) link[3 * (i) + (k)]
#define LESS(a, b) ((a) < (b) -> (a) : (b))

/* The other two of machine i. */
#define ONE(i) (((i) + 1) % MACHINES)
#define TWO(i) (((i) + 2) % MACHINES)

#define ALL_SAY_GONE(i) (FROM(ONE(i), i).known.gone && FROM(TWO(i), i).known.gone)
#define FEWEST_HERE(i) LESS(machine[i].own.next, LESS(FROM(ONE(i), i).known.next, FROM(TWO(i), i).known.next))
#define LOWEST_CUT(i) LESS(machine[i].own.cut, LESS(FROM(ONE(i), i).known.cut, FROM(TWO(i), i).known.cut))
#define TELLS(i, k) (FROM(k, i).known.cut == machine[i].own.cut)

#define SAYS_GONE(i) (machine[i].own.gone && (FAULT != 5 || machine[i].own.cut != NEVER))

inline send(sender, receiver) {
    FROM(sender, receiver).waits = true;
    FROM(sender, receiver).told.next = machine[sender].own.next;
    FROM(sender, receiver).told.gone = SAYS_GONE(sender);
    FROM(sender, receiver).told.cut = machine[sender].own.cut
}
inline take(sender, receiver) {
    FROM(sender, receiver).waits = false;
    FROM(sender, receiver).known.next = FROM(sender, receiver).told.next;
    FROM(sender, receiver).known.gone = FROM(sender, receiver).told.gone;
    FROM(sender, receiver).known.cut = FROM(sender, receiver).told.cut
}
#define NEW(i, k) (!(FROM(i, k).known.next == machine[i].own.next && FROM(i, k).known.gone == SAYS_GONE(i) && FROM(i, k).known.cut == machine[i].own.cut))
#define SAME(i, k) (FROM(i, k).waits && FROM(i, k).told.next == machine[i].own.next && \
                    FROM(i, k).told.gone == SAYS_GONE(i) && FROM(i, k).told.cut == machine[i].own.cut)

/* A tick is for good when X's input for it is here and everybody is known to have it. */
#define MAY_CONFIRM(i) (!machine[i].own.gone && machine[i].confirmed < machine[i].own.next && \
                        (FAULT == 1 || (machine[i].confirmed < FROM(ONE(i), i).known.next && machine[i].confirmed < FROM(TWO(i), i).known.next)))
#define MAY_TELL_CUT(i) (machine[i].own.gone && machine[i].own.cut == NEVER && (FAULT == 4 || ALL_SAY_GONE(i)))
#define MAY_SETTLE(i) (!machine[i].settled && machine[i].own.cut != NEVER && \
                       (FAULT == 3 || (TELLS(i, ONE(i)) && TELLS(i, TWO(i)))))

#define AGREE(i, k) (!(machine[i].settled && machine[k].settled) || machine[i].own.cut == machine[k].own.cut)
#define NOTHING_TAKEN(i) (!machine[i].settled || (machine[0].confirmed <= machine[i].own.cut && \
                          machine[1].confirmed <= machine[i].own.cut && machine[2].confirmed <= machine[i].own.cut))

inline check() {
    assert(AGREE(0, 1) && AGREE(1, 2) && AGREE(0, 2));
    assert(NOTHING_TAKEN(0) && NOTHING_TAKEN(1) && NOTHING_TAKEN(2))
}

proctype Plays(byte i) {
end:
    do
    /* An input of X arrives: refused once X has left. */
    :: atomic { machine[i].own.next < INPUTS && (FAULT == 2 || !machine[i].own.gone) -> machine[i].own.next++ }
    :: atomic { MAY_CONFIRM(i) -> machine[i].confirmed++; check() }
    :: atomic { !machine[i].own.gone -> machine[i].own.gone = true }
    :: atomic { MAY_TELL_CUT(i) -> machine[i].own.cut = (FAULT == 3 -> machine[i].own.next : FEWEST_HERE(i)) }
    :: atomic { FAULT != 3 && machine[i].own.cut != NEVER && !machine[i].settled && LOWEST_CUT(i) < machine[i].own.cut ->
                machine[i].own.cut = LOWEST_CUT(i) }
    :: atomic { MAY_SETTLE(i) -> machine[i].settled = true; check() }
    :: atomic { machine[i].own.cut != NEVER && LOWEST_CUT(i) < machine[i].confirmed -> assert(false) } /* the machine would stop */
    :: atomic { machine[i].settled && LOWEST_CUT(i) < machine[i].own.cut -> assert(false) } /* the machine would stop */
    :: atomic { NEW(i, ONE(i)) && !SAME(i, ONE(i)) -> send(i, ONE(i)) }
    :: atomic { NEW(i, TWO(i)) && !SAME(i, TWO(i)) -> send(i, TWO(i)) }
    :: atomic { FROM(ONE(i), i).waits -> take(ONE(i), i) }
    :: atomic { FROM(TWO(i), i).waits -> take(TWO(i), i) }
    od
}

init {
    byte i;
    atomic {
        for (i : 0 .. MACHINES - 1) { machine[i].own.cut = NEVER }
        for (i : 0 .. 8) { link[i].known.cut = NEVER; link[i].told.cut = NEVER }
        run Plays(0); run Plays(1); run Plays(2)
    }
    timeout; /* nothing is left to do: every step brings something on, so that this comes in the end */
    assert(machine[0].settled && machine[1].settled && machine[2].settled)
}
