/* One machine leaves while another one comes in: src/session/departure.cpp and join/admission.cpp together, made small.
 *
 * Machines 0 and 1 play, X leaves as in departure.pml, and J, machine 2, comes in from tick ENTRY on, which all have agreed on
 * (admission.pml). Each of the two takes it in when it likes, before or after X has left for it or its cut is settled. J plays from the
 * moment when one has taken it in, and has no input from before ENTRY. Who has settled a cut before ENTRY may have shown it a log in which X has
 * left; then J tells no cut. What goes between J and a machine that has not taken it in is not understood, so it is not sent here.
 *
 * What must hold, whatever happens first:
 *   agreement   who has settled the cut has the same one; for J all those before ENTRY are ENTRY
 *   no loss     no machine has confirmed a tick with X's true input that the cut takes from it
 *   no stop     honest machines never find that they cannot agree
 *   progress    all take J in and settle the cut in the end
 *
 * FAULT chooses a mutant, 0 none; each must violate one of these:
 *   1  the cut waits for who came in after it
 *   2  who came in takes a cut from before for what it is
 *   3  ticks are confirmed from which on another one comes in
 *   4  ticks are confirmed that who came in lacks
 *   5  a cut behind the tick where one comes in is settled before it is in
 */

#ifndef FAULT
#define FAULT 0
#endif

#define MACHINES 3
#define J 2
#define ENTRY 1
#define INPUTS 2 /* of X: one before ENTRY, one from there on */
#define NEVER 7

typedef Word {
    byte next;   /* of X's inputs: how many are here */
    bool gone;   /* X has left for it */
    byte cut     /* NEVER: not told */
};
typedef Link {
    bool waits;  /* a packet is on its way */
    Word told;   /* what it tells */
    Word known   /* what the receiver knows of the sender */
};
typedef Machine {
    Word own;
    byte confirmed; /* ticks that have run for good on X's true inputs */
    bool settled;
    bool has_in     /* it has taken J in */
};

Machine machine[MACHINES];
Link link[9]; /* from i to k: [3 i + k] */
bool plays;   /* J does */
bool was_told; /* by the log: X has left */

#define FROM(i, k) link[3 * (i) + (k)]
#define LESS(a, b) ((a) < (b) -> (a) : (b))
#define MORE(a, b) ((a) > (b) -> (a) : (b))
#define ONE(i) (((i) + 1) % MACHINES)
#define TWO(i) (((i) + 2) % MACHINES)

/* Whether i counts k among those who play, and hears it. */
#define COUNTS(i, k) ((i) == J -> plays : ((k) != J || machine[i].has_in))
#define HEARS(i, k) (((i) != J && (k) != J) || (plays && ((i) == J -> machine[k].has_in : machine[i].has_in)))

#define SAYS_GONE(i, k) (!COUNTS(i, k) || FROM(k, i).known.gone)
#define ALL_SAY_GONE(i) (SAYS_GONE(i, ONE(i)) && SAYS_GONE(i, TWO(i)))
#define NEXT_OF(i, k) (COUNTS(i, k) -> FROM(k, i).known.next : NEVER)
#define CUT_OF(i, k) (COUNTS(i, k) -> FROM(k, i).known.cut : NEVER)
#define FEWEST_HERE(i) LESS(machine[i].own.next, LESS(NEXT_OF(i, ONE(i)), NEXT_OF(i, TWO(i))))
#define LOWEST_CUT(i) LESS(machine[i].own.cut, LESS(CUT_OF(i, ONE(i)), CUT_OF(i, TWO(i))))
#define HAS_SAY(i, k) (COUNTS(i, k) && ((k) != J || FAULT == 1 || ENTRY <= machine[i].own.cut))
#define TELLS(i, k) (!HAS_SAY(i, k) || FROM(k, i).known.cut == machine[i].own.cut)
#define IS_OPEN(i) ((i) != J && !machine[i].has_in)

inline send(sender, receiver) {
    FROM(sender, receiver).waits = true;
    FROM(sender, receiver).told.next = machine[sender].own.next;
    FROM(sender, receiver).told.gone = machine[sender].own.gone;
    FROM(sender, receiver).told.cut = machine[sender].own.cut
}
inline take(sender, receiver) {
    FROM(sender, receiver).waits = false;
    FROM(sender, receiver).known.next = MORE(FROM(sender, receiver).known.next, FROM(sender, receiver).told.next);
    FROM(sender, receiver).known.gone = FROM(sender, receiver).told.gone;
    FROM(sender, receiver).known.cut = FROM(sender, receiver).told.cut;
    if
    :: receiver == J && FAULT != 2 -> FROM(sender, receiver).known.cut = MORE(FROM(sender, receiver).known.cut, ENTRY)
    :: else -> skip
    fi;
    FROM(sender, receiver).told.next = 0;
    FROM(sender, receiver).told.gone = false;
    FROM(sender, receiver).told.cut = 0
}
/* What the receiver does not know yet. */
#define CUT_AT(i, k) ((k) == J && FAULT != 2 -> MORE(machine[i].own.cut, ENTRY) : machine[i].own.cut)
#define NEW(i, k) (FROM(i, k).known.next < machine[i].own.next || FROM(i, k).known.gone != machine[i].own.gone || FROM(i, k).known.cut != CUT_AT(i, k))
#define SAME(i, k) (FROM(i, k).waits && FROM(i, k).told.next == machine[i].own.next && \
                    FROM(i, k).told.gone == machine[i].own.gone && FROM(i, k).told.cut == machine[i].own.cut)
#define MAY_SEND(i, k) (HEARS(i, k) && NEW(i, k) && !SAME(i, k))

/* A tick is for good when X's input for it is here, everybody is known to have it, and nobody comes in there whom it has not taken in. */
#define HAS_IT(i, k) (!COUNTS(i, k) || ((k) == J && FAULT == 4) || machine[i].confirmed < FROM(k, i).known.next)
#define MAY_CONFIRM(i) (!machine[i].own.gone && machine[i].confirmed < machine[i].own.next && HAS_IT(i, ONE(i)) && HAS_IT(i, TWO(i)) && \
                        (FAULT == 3 || !IS_OPEN(i) || machine[i].confirmed < ENTRY))
#define MAY_TELL_CUT(i) (machine[i].own.gone && machine[i].own.cut == NEVER && !machine[i].settled && ALL_SAY_GONE(i))
#define MAY_SETTLE(i) (!machine[i].settled && machine[i].own.cut != NEVER && TELLS(i, ONE(i)) && TELLS(i, TWO(i)) && \
                       (FAULT == 5 || !IS_OPEN(i) || machine[i].own.cut <= ENTRY))
#define STOPS(i) (LOWEST_CUT(i) < machine[i].confirmed || (machine[i].settled && LOWEST_CUT(i) < machine[i].own.cut))

#define AGREE(i, k) (!(machine[i].settled && machine[k].settled) || machine[i].own.cut == machine[k].own.cut)
#define AGREES_WITH_J(i) (!(machine[i].settled && machine[J].settled) || \
                          (was_told -> machine[i].own.cut < ENTRY : MORE(machine[i].own.cut, ENTRY) == machine[J].own.cut))
#define KEEPS(i) (!machine[i].settled || (machine[0].confirmed <= machine[i].own.cut && machine[1].confirmed <= machine[i].own.cut && \
                                          machine[J].confirmed <= MORE(machine[i].own.cut, ENTRY)))

inline check() {
    assert(AGREE(0, 1) && AGREES_WITH_J(0) && AGREES_WITH_J(1));
    assert(KEEPS(0) && KEEPS(1))
}

inline come_in(left) {
    plays = true;
    was_told = left;
    machine[J].own.next = ENTRY;
    machine[J].own.gone = left;
    machine[J].settled = left;
    machine[J].confirmed = ENTRY;
    FROM(0, J).known.next = ENTRY;
    FROM(1, J).known.next = ENTRY
}

proctype Plays(byte i) {
end:
    do
    /* An input of X arrives: refused once X has left. */
    :: atomic { (i != J || plays) && machine[i].own.next < INPUTS && !machine[i].own.gone -> machine[i].own.next++ }
    :: atomic { (i != J || plays) && MAY_CONFIRM(i) -> machine[i].confirmed++; check() }
    :: atomic { (i != J || plays) && !machine[i].own.gone -> machine[i].own.gone = true }
    :: atomic { MAY_TELL_CUT(i) -> machine[i].own.cut = FEWEST_HERE(i) }
    :: atomic { machine[i].own.cut != NEVER && !machine[i].settled && LOWEST_CUT(i) < machine[i].own.cut -> machine[i].own.cut = LOWEST_CUT(i) }
    :: atomic { MAY_SETTLE(i) -> machine[i].settled = true; check() }
    :: atomic { machine[i].own.cut != NEVER && STOPS(i) -> assert(false) } /* the machine would stop */
    :: atomic { i != J && !machine[i].has_in -> machine[i].has_in = true; FROM(J, i).known.next = ENTRY }
    :: atomic { i == J && !plays && (machine[0].has_in || machine[1].has_in) -> come_in(false) }
    :: atomic { i == J && !plays && ((machine[0].has_in && machine[0].settled && machine[0].own.cut < ENTRY) || 
                                     (machine[1].has_in && machine[1].settled && machine[1].own.cut < ENTRY)) -> come_in(true) }
    :: atomic { MAY_SEND(i, ONE(i)) -> send(i, ONE(i)) }
    :: atomic { MAY_SEND(i, TWO(i)) -> send(i, TWO(i)) }
    :: atomic { FROM(ONE(i), i).waits && HEARS(i, ONE(i)) -> take(ONE(i), i) }
    :: atomic { FROM(TWO(i), i).waits && HEARS(i, TWO(i)) -> take(TWO(i), i) }
    od
}

init {
    byte i;
    atomic {
        for (i : 0 .. MACHINES - 1) { machine[i].own.cut = NEVER }
        for (i : 0 .. 8) { link[i].known.cut = NEVER }
        run Plays(0); run Plays(1); run Plays(2)
    }
    timeout; /* nothing is left to do: every step brings something on, so that this comes in the end */
    assert(machine[0].settled && machine[1].settled && machine[J].settled && machine[0].has_in && machine[1].has_in)
}
