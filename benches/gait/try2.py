import sys, numpy as np, time
from stride import *
S=Stride(rigid=False)
x=S.guess(6,.3,.5)
for k,c,slip in ((2e4,0,1.),(2e4,.3,.5),(5e4,.6,.3),(1e5,1.,.2),(2e5,1.,.1)):
    x,i=S.solve(x,k=k,c=c,slip=slip,mu=(.66815,.66815),weight=1.0)
    i.pop('x'); print('   ',k,c,i,flush=True)
np.save('/tmp/biped_x.npy',x)
print([float(S.get(x,f"T{p}")[0]) for p in range(4)])
np.set_printoptions(precision=2,suppress=True,linewidth=200)
for p,i,s in S.points:
    h=S.get(x,f"T{p}")[0]/INTERVALS[p]
    tag=f"{p}_{i}_{s}"
    print(tag,S.get(x,"q"+tag),S.get(x,"w"+tag)/h,S.get(x,"u"+tag), np.array(points(ca.DM(S.get(x,"q"+tag)))[0][2]).ravel(), np.array(points(ca.DM(S.get(x,"q"+tag)))[1][2]).ravel())
