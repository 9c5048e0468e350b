# Garbage for a server: datagrams of every sort that is none of its own, at most RATE a second, to every port from FIRST
# to LAST of HOST; and nonsense to its control port. Until SIGTERM.   perl flood.pl HOST CONTROL FIRST LAST RATE
# For the perl-base that every Debian has.
use strict;
use warnings;
use Socket;

my ($host, $control, $first, $last, $rate) = @ARGV;
my $ended = 0;
$SIG{TERM} = sub { $ended = 1 };
$SIG{PIPE} = 'IGNORE';
srand(1);
my $address = inet_aton($host) or die "no host $host\n";
socket(my $udp, PF_INET, SOCK_DGRAM, 0) or die $!;
sub noise { pack('C*', map { int(rand(256)) } 1 .. $_[0]) }

# What a stranger can know: the protocol's text. A header is magic, version, kind, reserved, session, packet number.
my $header = sub { pack('a2CCVQ<Q<', 'FW', @_) . noise(120) };
my @garbage = map({ noise($_) } 0, 1, 23, 24, 25, 128, 200, 1200, 1400);
for my $version (1, 2, 255) {
  push @garbage, map({ $header->($version, $_, 0, int(rand(2**48)) << 8, 1 + int(rand(2**30))) } 0 .. 3, 255);
  push @garbage, $header->($version, 1, 7, 256, 1);
}
my ($sent, $begin, $turns) = (0, time, 0);
use constant TURNS => 500;  # [1/s]
until ($ended) {
  for (1 .. $rate / TURNS) {
    my $port = $first + $sent % ($last - $first + 1);
    send($udp, $garbage[rand @garbage], 0, pack_sockaddr_in($port, $address));
    ++$sent;
  }
  if (++$turns % 50 == 0) {  # ten times a second to the control port
    socket(my $tcp, PF_INET, SOCK_STREAM, 0) or next;
    if (connect($tcp, pack_sockaddr_in($control, $address))) {
      syswrite($tcp, noise(1 + int(rand(600))));
      close $tcp;
    }
  }
  select(undef, undef, undef, 1 / TURNS);
}
printf "sent %d datagrams in %d s\n", $sent, time - $begin;
