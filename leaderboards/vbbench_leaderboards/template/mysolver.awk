# A solver in a language that vbbench knows nothing of: CSV in, CSV out. Everybody, the observer too, goes on as in the two
# frames in which he was given. Protocols sequential and rollout.
#
#   vbbench export csv DATASET --out boxes
#   mkdir answer && awk -v out=answer -f mysolver.awk boxes/given.csv boxes/observations.csv
#
# Units: metres, radians, frames that count from 0. Track -1 is the observer. Rows that were given may be left out.
BEGIN { FS = OFS = ","; CONVFMT = OFMT = "%.12g"
        print "sequence,frame,x,y,yaw" > (out "/poses.csv")
        print "sequence,frame,track,x,y" > (out "/positions.csv") }
FNR == 1 { table++; next }                                  # the header of each file
table == 1 {                                                # given.csv: sequence,frame,track,x,y,yaw
    key = $1 SUBSEP $3
    if ("rollout" == protocol && $2 > 1) next
    known[$1, $2, $3] = 1
    f0[key] = f1[key]; x0[key] = x1[key]; y0[key] = y1[key]; yaw0[key] = yaw1[key]
    f1[key] = $2;      x1[key] = $4;      y1[key] = $5;      yaw1[key] = $6
    times[key]++; next
}
function onward(key, frame, last, before) {                 # along a straight line through the two given frames
    if (times[key] < 2) return last
    return last + (last - before) * (frame - f1[key]) / (f1[key] - f0[key])
}
{                                                           # observations.csv: sequence,frame,track,u,v,l,visible
    me = $1 SUBSEP (-1); who = $1 SUBSEP $3
    if ($2 >= 2 && !(($1, $2) in posed)) {
        posed[$1, $2] = 1
        print $1, $2, onward(me, $2, x1[me], x0[me]), onward(me, $2, y1[me], y0[me]), yaw1[me] > (out "/poses.csv")
    }
    if ($2 < 2 || ($1, $2, $3) in known) next
    if (!(who in times)) { x1[who] = x1[me]; y1[who] = y1[me]; times[who] = 1 }   # rollout's strangers: a poor guess
    print $1, $2, $3, onward(who, $2, x1[who], x0[who]), onward(who, $2, y1[who], y0[who]) > (out "/positions.csv")
}
