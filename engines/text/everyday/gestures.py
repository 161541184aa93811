"""How people ask for gestures: of the hands, of greeting and parting, and signs drawn in the air."""

from __future__ import annotations

SENTENCES: dict[str, str] = {
    "wave left hand": """
        wave with your left hand; She waves her left hand.; a left-handed wave; left hand wave; say hi with the left;
        He lifts his left arm and waves hello.; waving the left hand; greet somebody with the left hand;
        My neighbour says hello with a wave of the left hand.; Wave, but use the left one.; left arm up, waving;
        The singer waves at her fans with the left hand.; a friendly wave from the left;
        shake the left hand at the camera to say hi; someone is waving with his left hand; a hello with the left;
        her other hand holds a coffee, so she waves with the left; wag the left hand in greeting; hi there, left hand;
        The boy waves to his mum, left hand high.; left palm out, wiggling side to side; Wave your left arm about.;
        He flags down a taxi with the left hand.; move the left hand back and forth in the air; a lefty waves hi;
        the queen gives a wave of her left hand; keep waving that left hand""",
    "wave right hand": """
        wave with your right hand; He waves his right hand.; a right-handed wave; right hand wave; right arm up, waving;
        She lifts her right arm and waves hello.; waving the right hand; greet somebody with the right hand;
        My teacher says hello with a wave of the right hand.; Wave, but use the right one.; say hi with the right;
        The pop star waves at his fans with the right hand.; a friendly wave from the right;
        shake the right hand at the camera to say hi; someone is waving with her right hand; a hello with the right;
        his other hand holds a phone, so he waves with the right; wag the right hand in greeting; hi there, right hand;
        The girl waves to her dad, right hand high.; right palm out, wiggling side to side; Wave your right arm about.;
        She flags down a bus with the right hand.; move the right hand back and forth in the air;
        the president gives a wave of his right hand; keep waving that right hand""",
    "wave both hands": """
        wave with both hands; She waves both hands over her head.; two-handed wave; both arms waving;
        He is stranded and waves both arms at the ship.; wave both hands in the air; waving with both arms;
        Hey, over here! with both hands; flail both arms to be noticed; hello with two hands;
        My aunt waves with both hands from the balcony.; two hands swinging side to side up high; both hands, hi there;
        A hiker signals the helicopter with both arms.; swing both arms overhead; say hi with both hands at once;
        at the concert everyone waves both arms to the song; she sees her friend and waves with two hands;
        shake both hands at the crowd; both palms out, waving; Use both hands to wave.; waving like mad with both hands;
        The ground crew waves both arms at the plane.; a wave of both hands; two arms waving hello;
        somebody greets the train with both hands""",
    "raise left hand": """
        raise your left hand; put the left hand up; He raises his left hand to ask a question.; left hand up;
        She lifts her left arm and lowers it again.; a raised left hand; left arm up, then down; hold up the left hand;
        The pupil knows the answer and sticks up the left hand.; vote with the left hand; left hand in the air;
        Lift your left hand above your head.; raising the left arm; my colleague puts up her left hand to speak;
        stretch the left arm to the ceiling and let it drop; one arm up, the left; someone raises the left hand;
        who wants cake? up goes his left hand; Left hand high, please.; bring the left hand up and back down;
        the referee holds up the left arm; volunteer by raising the left hand; a man with his left hand up;
        bidding at the auction, left hand up; left arm overhead; She shows her left palm, up high.""",
    "raise right hand": """
        raise your right hand; put the right hand up; She raises her right hand to ask a question.; right hand up;
        He lifts his right arm and lowers it again.; a raised right hand; right arm up, then down;
        hold up the right hand; The student knows the answer and sticks up the right hand.; vote with the right hand;
        Lift your right hand above your head.; raising the right arm; right hand in the air; right arm overhead;
        my boss puts up his right hand to speak; stretch the right arm to the ceiling and let it drop;
        one arm up, the right; someone raises the right hand; who wants ice cream? up goes her right hand;
        Right hand high, please.; bring the right hand up and back down; the umpire holds up the right arm;
        The witness raises her right hand and swears.; volunteer by raising the right hand;
        bidding at the market, right hand up; He shows his right palm, up high.""",
    "raise both hands": """
        raise both hands; hands up, both of them; He surrenders with both hands in the air.; both arms up;
        She lifts both arms and lowers them again.; two hands up; put both hands over your head; raising both arms;
        The winner throws both arms up.; goal! both arms in the air; reach for the sky with both hands;
        don't shoot, both hands are up; both arms straight up, then down; lift two hands above the head;
        My yoga teacher raises both arms and breathes out as they sink.; victory pose, both arms raised;
        hold both hands up high; a person raises both hands; on the roller coaster she keeps both hands up;
        Both hands to the ceiling, please.; the marathon winner crosses the line with both arms up;
        bring both arms up and down once; the robber shouts and he puts both hands up; praise with both hands lifted;
        stretch both arms upward in the morning; touchdown, both arms""",
    "bow": """
        bow; take a bow; He bows to the audience.; a deep bow; bend forward politely; She bows before the emperor.;
        bowing; the magician bows at the end of the show; a Japanese greeting, from the waist;
        lower your upper body in greeting; The curtain falls and the actors bow.; Bow your head and body.;
        show respect by bending over; a courteous bow; My host bows to welcome me.;
        bend at the hips to greet, then straighten; he thanks the crowd with a bow;
        Before the fight, the judoka bow to each other.; your majesty, with a bow; a slight bow; incline the body;
        someone leans forward in respect; The butler bows.; a formal apology, head low; bend the back for the king;
        the pianist gets up from the piano and takes her bow""",
    "wave goodbye": """
        wave goodbye; bye bye everyone; She waves farewell.; see you later, with a small wave; goodbye; waving bye;
        He waves as his friends drive off.; a little wave goodbye; Say bye with your hand.; so long, everyone;
        My grandmother waves us off from the door.; wave the guests off; parting wave; bye for now;
        The party is over and she waves to the others.; it is time to go, a quick wave; take leave with one hand;
        At the school gate the mother waves goodbye.; see you tomorrow; a person waves farewell with one hand;
        he lifts a hand to say bye; ciao; time to part, hand waving; The train pulls out and he gives a small wave.;
        a modest goodbye; waves bye to the baby; Wave to those who go.""",
    "wave goodbye big": """
        a big wave goodbye; She waves goodbye with her whole arm.; a huge farewell wave; wide swings of the arm, bye;
        He swings his arm in a wide arc to say goodbye.; wave so they still see you from the ship;
        large sweeping goodbye; say farewell with big gestures; Goodbye, goodbye, arm swinging wide!; giant bye bye;
        The ferry is far out and my uncle still waves with all his arm.; an exaggerated wave goodbye;
        broad arm waving as the bus drives away; wave farewell as wide as you can; goodbye in a grand sweep;
        At the airport she waves goodbye in big arcs.; bye with the arm swung high and wide; farewell across the valley;
        a sweeping wave to friends leaving on the boat; make your goodbye visible from afar; expansive goodbye wave;
        someone waves goodbye with a large swing of the arm; see you, with an enormous wave; so long, big time;
        Wave them off with your arm stretched out wide.; the goodbye is overdone, the whole arm swings""",
    "beckon": """
        come here; He beckons his friend over.; wave somebody over; beckoning; Call her over with your arm.;
        She motions for the waiter to come.; come closer, come on; get over here, with a hand sign; a come-here gesture;
        The teacher gestures for a pupil to come to the desk.; summon someone with a hand; invite them to come nearer;
        Signal the driver to roll up to you.; my mum calls us in for dinner with her arm; hey you, come to me;
        a person beckons; gesture toward yourself; he wants his dog to come back to him; bring it on, hand curling in;
        The witch lures them closer with her hand.; ask someone over without words;
        pull the air towards you to call a friend; follow me over here, she gestures; the coach calls a player over;
        come come come; wave her in closer""",
    "guide": """
        please follow my arm, madam; He shows the guests the way.; point out the direction; guiding; after you;
        She ushers them to their table.; An usher shows where the seats are.; lead the way with your arm;
        The receptionist gestures toward the lift.; over there, down that hall; give directions with an arm;
        the doorman sweeps an arm toward the entrance; direct visitors to the exit; present the way in;
        My host gestures for me to go in first.; show a tourist where the station is; step inside, please;
        a person guides somebody with an arm; it's just around that corner, she indicates; welcome, do come through;
        The waiter extends his arm toward a free table.; steer people along; pointing the way;
        a museum guide indicates the next room; that's the way to go, arm out; show someone in""",
    "respond": """
        respond to a call; He answers with a gesture.; yes, that's me; someone calls and she reacts;
        here! she signals when her name is read out; acknowledge the call; I heard you, with a hand sign; reply;
        The boss shouts across the hall and he signals back.; responding; answer without speaking;
        over here, I hear you; My friend hears her name and gestures that she heard.;
        give a sign that you got the message; respond; roger that, with a hand sign;
        A worker confirms the order with a short gesture.; present! at roll call; react to somebody calling you;
        a person responds to being called; signal back to the one who called; got it, coming;
        He looks up and answers the shout with his arm.; return a call with a gesture;
        the player answers the coach with a sign; okay, understood, he gestures""",
    "clap": """
        clap; hands together, clap clap clap; He applauds.; a round of applause; clapping; bravo!;
        She claps to the beat.;
        What a concert, the woman in row three can't stop applauding.; give them a hand, everybody;
        My grandfather claps when the plane lands.; palms together, again and again; hands smacking together;
        The audience member rises and gives an ovation.; applause for the winner; a few claps; polite applause;
        bring the hands together with a bang; Congratulate the team by clapping.; the play is over, people applaud;
        a person claps; clap clap clap; she was wonderful, he puts his hands together for her; hit palm on palm;
        He claps along with the song.; kill the mosquito between your hands; slow applause;
        the teacher claps for silence""",
    "cross arms": """
        cross your arms; He folds his arms.; arms crossed; arms folded across the chest; folding the arms;
        She crosses her arms and waits.; stand there with folded arms; The bouncer folds his arms.; fold arms;
        I'm not convinced, with crossed arms; put one arm over the other in front of your chest; closed off posture;
        My father crosses his arms and shakes his head.; arms locked in front of the body; cross both arms at the chest;
        a person crosses the arms; the jury member leans back, arms folded; Lock your arms across the chest.;
        she isn't having it and folds her arms; no entry, arms crossed in front; crossing of the arms;
        the genie folds his arms; arms over the chest in an X; He hugs himself with crossed arms.;
        defensive body language, arms folded; bring the forearms together over the breast""",
    "swipe left": """
        swipe left; swipe to the left; She swipes left on the profile.; a left swipe; flick it to the left;
        not my type, swipe left; He brushes the air to the left.; push the menu away to the left; swiping left;
        wave the slide off to the left; the arm sweeps to the left; on to the next page with a swipe left;
        Swipe the screen in the air toward the left.; move your hand quickly to the left; slide your arm left;
        a gesture that throws the window to the left; wipe to the left; a smooth swipe toward your left;
        My friend scrolls left through the big display.; flip the page with a sweep to the left; sweep left;
        The speaker swipes left to change the slide.; a person swipes an arm to the left; dating app, left;
        drag everything over to the left with one arm; hand travels left across the chest""",
    "swipe right": """
        swipe right; swipe to the right; He swipes right on the profile.; a right swipe; flick it to the right;
        it's a match, swipe right; She brushes the air to the right.; push the menu away to the right; swiping right;
        wave the slide off to the right; the arm sweeps to the right; back one page with a swipe right;
        Swipe the screen in the air toward the right.; move your hand quickly to the right; slide your arm right;
        a gesture that throws the window to the right; wipe to the right; a smooth swipe toward your right;
        My colleague scrolls right through the big display.; turn the page with a sweep to the right; sweep right;
        The presenter swipes right to change the slide.; a person swipes an arm to the right; dating app, right;
        drag everything over to the right with one arm; hand travels right, away from the chest""",
    "draw x": """
        draw an x; draw an X in the air; He makes a cross in the air.; x marks the spot; trace the letter x;
        She writes an x with her hand.; an X in midair; two crossing strokes in the air; cross it out;
        Cross out an invisible word.; wrong answer, he draws a big x; tic-tac-toe, your turn with the cross;
        My teacher signs an X in front of her.; drawing a cross shape with one hand; a gesture in the shape of an x;
        the letter before y, written in the air; paint a large X; a person draws an x; sign with an x;
        two diagonals, one after the other, with the hand; Zorro would pick a Z, she draws an X; slanted cross;
        put a cross on the imaginary ballot; strike through something in the air with two lines; big X, hand in front;
        outline of an x in front of you; The pirate draws where the treasure is, an X in the air.""",
    "draw circle clockwise": """
        draw a circle clockwise; a clockwise circle in the air; She traces a clockwise ring.; clockwise circle;
        circle your hand clockwise; He draws a wheel in the air, clockwise.; round and round, clockwise;
        move your hand like a clock hand, clockwise, all the way round; stir the air clockwise; big clockwise loop;
        wind the invisible handle clockwise; the hand goes round clockwise; drawing a clockwise circle;
        My daughter paints a clockwise circle in front of her.; write the letter O clockwise in the air;
        polish the window in one clockwise circle; a person draws a circle, clockwise; full turn of the arm, clockwise;
        make a round shape in the air going clockwise; trace the clock face, clockwise from twelve;
        clockwise hand circle; Loop your arm clockwise.; turn the big dial clockwise;
        a wizard draws a clockwise magic circle; circle, the way the clock runs, clockwise;
        one clockwise round with the arm""",
    "draw circle counterclockwise": """
        draw a circle counterclockwise; a counterclockwise circle in the air; He traces an anticlockwise ring.;
        counterclockwise circle; circle your hand anticlockwise; She draws a wheel in the air, counterclockwise.;
        round and round, counterclockwise; against the clock, a counterclockwise circle by hand; anti-clockwise loop;
        stir the air counterclockwise; wind the invisible handle anticlockwise; the hand goes round counterclockwise;
        drawing an anticlockwise circle; My son paints a counterclockwise circle in front of him.;
        write the letter O counterclockwise in the air; polish the mirror in one counterclockwise circle;
        a person draws a circle, counterclockwise; full turn of the arm, counterclockwise; anticlockwise hand circle;
        make a round shape in the air going counterclockwise; trace the clock face backwards, anti-clockwise;
        Loop your arm counterclockwise.; turn the big dial anticlockwise;
        a sorceress draws an anticlockwise ring of fire; circle, but not the way the clock runs, counterclockwise;
        one anticlockwise round with the arm""",
    "draw triangle": """
        draw a triangle; a triangle in the air; She traces a triangle.; three lines, three corners; triangle;
        outline a pyramid with your hand; drawing a triangle in midair; He sketches a triangular road sign in the air.;
        make a three-sided shape with your hand; up, down and across, a triangle; paint a triangle with one finger;
        The maths teacher draws a triangle without a board.; trace the shape of a slice of pizza; triangular gesture;
        draw the roof of a house in the air, with its base; a person draws a triangle; delta sign drawn in the air;
        My nephew draws a tent in the air.; hand along the three edges of a triangle; triangle shape, one hand;
        Draw something with three corners.; connect three points in the air; a geometric figure with three sides;
        the conductor beats a triangle in the air; air-draw a triangle;
        the triangle player shows her instrument's shape by hand""",
}
