"""The same streets on other days and through other cameras: materials, shade, light, lens and sensor, drawn anew for every picture.

The simulator draws what stands where; what it looks like there is varied far beyond what the simulator's own materials are, so that the
network leans on what holds for roads anywhere and not on a renderer's colours.
"""

import numpy as np
import torch
import torch.nn.functional as F

from pictures import PAINT, RAISED, ROAD, SKY, STRUCTURE, THING, VERGE


class Days:
    """Draws days; one random stream for numbers, one for noise."""

    def __init__(self, shape, seed):
        self.h, self.w = shape.height, shape.width
        self.rng = np.random.default_rng(seed)
        self.noise = torch.Generator().manual_seed(seed)
        ys, xs = torch.meshgrid(torch.linspace(0, 1, self.h), torch.linspace(0, 1, self.w), indexing="ij")
        self.ys, self.xs = ys, xs

    def chance(self, share):
        return self.rng.random() < share

    def field(self, coarsest=3, finest=40):
        """A smooth random field of unit variance; rows are drawn out towards the bottom as ground is in perspective."""
        rows, columns = (int(np.exp(self.rng.uniform(np.log(coarsest), np.log(finest)))) for _ in range(2))
        z = torch.randn(1, 1, rows, columns, generator=self.noise)
        return F.interpolate(z, size=(self.h, self.w), mode="bicubic")[0, 0]

    def grain(self):
        """Fine texture, coarser towards the viewer."""
        fine = torch.randn(1, 1, self.h, self.w, generator=self.noise)
        soft = F.avg_pool2d(F.pad(fine, (2, 2, 2, 2), mode="replicate"), 5, 1)[0, 0] * 5
        near = (self.ys - self.rng.uniform(0.2, 0.6)).clamp(0, 1)
        return fine[0, 0] * (1 - near) + soft * near

    def tint(self, sigma):
        return torch.tensor(np.exp(self.rng.normal(0, sigma, 3)), dtype=torch.float32).view(3, 1, 1)

    def __call__(self, pictures, classes):
        """Pictures (levels 0 to 1) and classes, each changed in its own way."""
        out = [self.one(x, c) for x, c in zip(pictures, classes)]
        return torch.stack([x for x, _ in out]), torch.stack([c for _, c in out])

    def one(self, x, classes):
        if self.chance(0.5):
            x, classes = x.flip(-1), classes.flip(-1)
        x = self.materials(x, classes)
        x, classes = self.things(x, classes)
        x = self.shade(x, classes)
        x, classes = self.bonnet(x, classes)
        return self.camera(self.light(x, classes)), classes

    def materials(self, x, classes):
        """Other ground, walls and sky than the simulator's."""
        road = ((classes == ROAD) | (classes == PAINT)).float()
        bare = classes == ROAD
        tone = x[:, bare].mean(1).view(3, 1, 1) if bare.sum() > 50 else torch.full((3, 1, 1), 0.35)
        for kind in (RAISED, VERGE, STRUCTURE, THING):
            there = (classes == kind).float()
            if there.sum() < 20 or not self.chance(0.5):
                continue
            grey = x.mean(0, keepdim=True)
            if kind in (RAISED, VERGE) and self.chance(0.3):
                # Ground of about the road's own tone, as asphalted pavements and trodden verges have.
                pattern = (grey / grey[:, there > 0].mean().clamp_min(0.03)).clamp(0.2, 3) ** self.rng.uniform(0, 1)
                other = tone * self.tint(0.08) * np.exp(self.rng.normal(0, 0.2)) * pattern
            elif self.chance(0.5):
                other = (grey + (x - grey) * self.rng.uniform(0, 1.3)) * self.tint(0.3) * np.exp(self.rng.normal(0, 0.4))
            else:
                base = torch.tensor(self.rng.uniform(0.05, 0.9, 3), dtype=torch.float32).view(3, 1, 1)
                base = base.mean() + (base - base.mean()) * self.rng.uniform(0, 0.8)
                other = base * (1 + self.rng.uniform(0, 0.35) * self.field()[None] + self.rng.uniform(0, 0.25) * self.grain()[None])
            x = x * (1 - there) + other.clamp(0, 2) * there
        if self.chance(0.5):
            colour = self.tint(0.15) * np.exp(self.rng.normal(0, 0.3))
            worn = 1 + self.rng.uniform(0, 0.18) * self.field()[None] + self.rng.uniform(0, 0.12) * self.grain()[None]
            x = x * (1 - road) + x * colour * worn.clamp(0.3, 2) * road
        return self.seams(x, road)

    def seams(self, x, road):
        """Tar, cracks and patches on the road."""
        for _ in range(self.rng.poisson(0.6)):
            z = self.field(4, 30)
            line = torch.sigmoid((0.03 - z.abs()) * self.rng.uniform(30, 120)) * (self.ys > 0.3)
            if self.chance(0.4):
                line = torch.sigmoid((z - self.rng.uniform(0.8, 1.6)) * 20)
            x = x * (1 - line * road * (1 - np.exp(self.rng.normal(-0.35, 0.3))))
        return x

    def things(self, x, classes):
        """Boxes of any look that stand on the ground, darker ground under them."""
        if not self.chance(0.35):
            return x, classes
        x, classes = x.clone(), classes.clone()
        for _ in range(1 + self.rng.poisson(1.0)):
            foot = self.rng.uniform(0.42, 1.05)
            size = (foot - 0.35) * self.rng.uniform(0.25, 1.1)
            middle, wide = self.rng.uniform(-0.1, 1.1), size * self.rng.uniform(0.4, 1.2)
            inside = ((self.xs - middle).abs() < wide / 2) & (self.ys < foot) & (self.ys > foot - size)
            corner = (((self.xs - middle) / (wide / 2)).abs() ** 4 + ((self.ys - foot + size / 2) / (size / 2)).abs() ** 4) < 1.0
            inside &= corner if self.chance(0.7) else inside
            ground = (classes != SKY) & (classes != STRUCTURE)
            under = torch.exp(-((self.ys - foot) / (0.15 * size + 0.01)) ** 2) * ((self.xs - middle).abs() < wide * 0.55) * ground
            x *= 1 - under * self.rng.uniform(0.3, 0.95)
            base = torch.tensor(self.rng.uniform(0.02, 0.95, 3), dtype=torch.float32).view(3, 1, 1)
            base = base.mean() + (base - base.mean()) * self.rng.uniform(0, 1)
            glass = torch.where(self.ys < foot - size * self.rng.uniform(0.5, 0.7), self.rng.uniform(0.1, 0.8), 1.0)
            look = (base * glass * (1 + 0.25 * self.field(3, 20)) * (1.3 - 0.6 * (self.ys - foot + size) / size)).clamp(0, 1.5)
            x = torch.where(inside[None], look, x)
            classes[inside] = THING
        return x, classes

    def shade(self, x, classes):
        """Bands of buildings' shade and dapples of trees', on ground, things and walls alike."""
        shown = (classes != SKY).float()
        for _ in range(self.rng.poisson(1.2)):
            if self.chance(0.5):
                angle, across, down = self.rng.random() * 2 * np.pi, *self.rng.random(2)
                band = (self.xs - across) * np.cos(angle) + (self.ys - down) * np.sin(angle) * 0.6
                mask = torch.sigmoid((self.rng.uniform(0.03, 0.5) - band.abs()) / self.rng.uniform(0.002, 0.03))
            else:
                z = 0.7 * self.field(3, 16) + 0.7 * self.field(10, 60)
                mask = torch.sigmoid((z - self.rng.uniform(-0.5, 1)) * self.rng.uniform(3, 25))
            mask = mask * shown
            x = x * (1 - mask + mask * np.exp(self.rng.uniform(-1.9, 0.3)) * self.tint(0.06))
        return x

    def bonnet(self, x, classes):
        """The vehicle's own bonnet, which mirrors the sky; it hides the ground like any thing."""
        if not self.chance(0.15):
            return x, classes
        top, bulge = self.rng.uniform(0.82, 0.98), self.rng.uniform(-0.1, 0.35)
        inside = self.ys > top + bulge * (self.xs - self.rng.uniform(0.35, 0.65)) ** 2
        base = torch.tensor(self.rng.uniform(0.02, 0.9, 3), dtype=torch.float32).view(3, 1, 1)
        base = base.mean() + (base - base.mean()) * self.rng.uniform(0, 1)
        mirror = x.flip(-2).mean((1, 2), keepdim=True) * self.rng.uniform(0, 0.6)
        look = base * (0.7 + 0.6 * (self.ys - top) / (1 - top + 0.01)) + mirror + 0.1 * self.field(3, 12)
        classes = torch.where(inside, THING, classes)
        return torch.where(inside[None], look.clamp(0, 1.2), x), classes

    def light(self, x, classes):
        """Over-exposed walls and skies, dusk and night with pools of light, fog."""
        if self.chance(0.3):
            for kind in (SKY, STRUCTURE):
                if self.chance(0.5):
                    there = (classes == kind).float()
                    x = x * (1 + there * self.rng.uniform(0, 2.5))
        if self.chance(0.2):
            middle, reach = self.rng.uniform(0.3, 0.7), self.rng.uniform(0.2, 0.8)
            pool = torch.exp(-(((self.xs - middle) / reach) ** 2 + ((self.ys - self.rng.uniform(0.6, 1.0)) / 0.5) ** 2))
            x = x * (self.rng.uniform(0.08, 0.6) + self.rng.uniform(0, 0.5) * pool)
        if self.chance(0.12):
            veil = (1 - (self.ys - 0.3).clamp(0, 1)) ** self.rng.uniform(1, 4) * self.rng.uniform(0.1, 0.7)
            x = x * (1 - veil) + veil * self.rng.uniform(0.3, 0.9)
        return x

    def camera(self, x):
        """Exposure, white balance, tone curve, saturation, vignette, blur, grain of the sensor, eight bits."""
        x = (x.clamp(0, 4) * np.exp(self.rng.normal(0, 0.35)) * self.tint(0.1)).clamp(0, 1)
        x = x ** np.exp(self.rng.normal(0, 0.3))
        grey = x.mean(0, keepdim=True)
        saturation = 0.0 if self.chance(0.15) else self.rng.uniform(0.1, 1.4)
        x = grey + (x - grey) * saturation
        off_centre = (self.xs - 0.5) ** 2 + (self.ys - 0.5) ** 2
        x = x * (1 - self.rng.uniform(0, 0.9) * off_centre * self.chance(0.4))
        if self.chance(0.3):
            kernel = (3, 1) if self.chance(0.5) else (3, 3)
            pad = (kernel[1] // 2,) * 2 + (kernel[0] // 2,) * 2
            x = F.avg_pool2d(F.pad(x[None], pad, mode="replicate"), kernel, 1)[0]
        x = x + torch.randn(x.shape, generator=self.noise) * (self.rng.random() ** 2 * 0.05)
        return torch.round(x.clamp(0, 1) * 255) / 255
