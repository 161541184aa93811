"""Requests for what no action of the vocabulary is, so that a reader of prompts learns to say so."""

from __future__ import annotations

REQUESTS = """
    swim across the lake; she dives into the pool; drive a car; ride a bicycle down the road; play the piano; strum
    a guitar; type on a keyboard; read a newspaper; sleep in a bed; lie down and rest; snore loudly; crawl on hands
    and knees; do a backflip; do push-ups; sit-ups on the mat; hang the laundry on a line; cook dinner; chop onions;
    drink a cup of coffee; eat an apple with one hand; brush your teeth; comb your hair; tie your shoelaces; put on
    a jacket; take off the hat; open an umbrella; unlock the car; paint a fence; hammer a nail into the wall; saw a
    plank in half; dig a hole with a shovel; mow the lawn; hug a friend; kiss on the cheek; shake hands with the
    boss; high five; salute the general; pray on your knees; kneel down; cry into your hands; laugh out loud;
    sneeze; cough; yawn and stretch; scratch your head; look around nervously; nod yes; shake your head no; shrug;
    point at the sky; give a thumbs up; take a photograph; make a phone call; carry a heavy crate; lift a barbell
    overhead; row a boat; paddle a kayak; ski down the slope; skateboard trick; ice skating; surf a wave; climb into
    a taxi; fly like a superhero; float in space; fall off a ladder; stumble and fall; roll on the ground;
    somersault; handstand; yoga pose downward dog; meditate cross-legged; spin on your back; shoot an arrow with a
    bow; fire a rifle; reload a gun; hide behind a wall; sneak past the guard; golf swing; play table tennis; spike
    a volleyball; header in football; goalkeeper dive; pull a rope; drag a sack; sweep the floor; vacuum the carpet;
    wash the dishes; iron a shirt; play the drums; conduct an orchestra; sing into a microphone; stand still; idle;
    wait for the bus; lean against the wall; smoke a cigarette; cross your legs; whisper a secret; listen at the
    wall; feed the ducks; stroke a cat; milk a cow; plant a tree; pour water into a glass; stir the soup; write a
    letter; draw a portrait; sew a button; change a light bulb; turn a steering wheel; do the laundry; bake a cake;
    fry an egg; set the table; open the fridge; close the window; slam the door; go through the door; ride a horse;
    gallop on horseback; ride the elevator; drive a truck; fly a plane; parachute jump landing; abseil down a cliff;
    swim butterfly; tread water; water polo; build a sandcastle; build a snowman; ski jump; curling with a broom;
    hockey slap shot; rugby tackle; wrestle an opponent; judo throw of a partner; sumo match; arm wrestling; tug of
    war; jump rope; hula hoop; trampoline tricks; rings routine; pole vault; javelin; shot put; discus; hurdles;
    relay baton pass; triathlon; marathon finish line collapse; breakdance head spin; moonwalk; waltz with a
    partner; ballet pirouette on pointe; tap shoes; limbo under a bar; blow out candles; blow a kiss; cover your
    ears; hold your nose; rub your eyes; wipe sweat off the forehead; check the watch; count money; pay at the till;
    push a shopping cart; pull a suitcase; carry a child on the shoulders; rock a baby; tickle; slap in the face;
    choke somebody; faint; die dramatically; get shot; duck under a beam; cower in fear; shiver with cold; warm your
    hands at the fire; fan yourself; swat a fly; catch fish with a rod; chop wood with an axe; rake leaves; push a
    wheelbarrow; lay bricks; paint the ceiling; climb through a window; crawl under a fence; slide down a slope;
    swing on a rope; hang by one hand; roll over in bed; wake up and rub the eyes; play chess; deal cards; roll
    dice; juggle three balls; do a card trick; play the violin; play the flute; beat a drum; dj at the turntable;
    sign a contract; stamp a letter; staple papers; use a mouse; play a video game; take a selfie; film with a
    camera; look through binoculars; talk on the phone; give a speech at a lectern; teach at the blackboard; argue
    with the referee; flirt at the bar; kiss the bride; carry a tray of glasses; pour wine; eat soup with a spoon;
    chew gum; drink from a bottle; smoke a pipe; spit; vomit; blow your nose; shave; put on lipstick; dry your hair;
    button a shirt; zip the jacket; pull up socks; polish shoes; fold a blanket; make the bed; dust the shelves;
    clean the window; feed a baby; walk the dog on a leash; pet a dog; whistle; clear your throat; breathe deeply;
    look up at the stars; look over the shoulder; sit cross-legged; lie on the back; lie face down; kneel and
    propose; curtsy; genuflect; cross yourself; bump fists; pat on the back; lift a partner; piggyback ride; human
    pyramid; hello; motion; something cool; a person; the quick brown fox; quarterly report; blue; 42
"""
