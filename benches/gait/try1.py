import sys, numpy as np, time
from stride import Stride
S=Stride(rigid=False)
for speed,period,amp in ((4,.3,.4),(7,.2,.5),(9,.2,.5)):
    x=S.guess(speed,period,amp)
    t=time.time()
    for k,c,slip in ((2e4,0.,1.),(2e4,.3,.5),(5e4,.6,.3),(1e5,1.,.2),(2e5,1.,.1)):
        x,i=S.solve(x,k=k,c=c,slip=slip,mu=(.66815,.66815),weight=1.0)
        i.pop('x'); print('   ',k,c,i,flush=True)
    print(speed,[round(float(S.get(x,f"T{p}")[0]),4) for p in range(4)],time.time()-t,flush=True)
    np.save(f'/tmp/biped_x{speed}.npy',x)
    for name,mu in (("asym",(.9049,.4314)),("back",(.4314,.9049))):
        y,i=S.solve(x,k=2e5,c=1,slip=.1,mu=mu,weight=1.0)
        i.pop('x'); print('   ',name,i,flush=True)
