"""Motion capture of real dancers over the network: VMC and PosiStageNet. It may import what `control` may."""
